"""Find the real ROS 2 on this machine and describe the environment in which Python can import it.

Three layouts are known: apt's ROS 2 that has been sourced; the wheels in the interpreter's own
site-packages (a venv, conda); and the wheels under a Debian or Ubuntu system Python, where pip puts
them in `/usr/local/lib/pythonX.Y/site-packages`, which is not on `sys.path`.
"""

from __future__ import annotations

import os
import re
import site
import sys
import sysconfig
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rclpy_portable import DISTRO, unpacking
from rclpy_portable.wheels import DownloadFailed
from rclpy_virtual_time.link import system
from rclpy_virtual_time.link.errors import NoRos

# rclpy's versions whose names virtual time replaces (rclpy_virtual_time/host/virtual)
GRADED = {"7.1": "jazzy", "9.1": "kilted"}
HOW_TO_INSTALL = (
    "install the wheels with `pip install '.[ros]'`, or source /opt/ros/jazzy/setup.bash"
)
# two ROSes' wheels have the same names, and one would take the other's place
BESIDE = "`pip install '.[ros]'` in a fresh virtual environment brings Jazzy's beside it"
NO_WHEELS = "there are no wheels of it for Python"
# its stamps are those of the machine, as the stamps of DDS are
PORTABLE_PRELUDE = (
    "import _time_machine, rclpy_portable.native.machine as machine;"
    "machine.use_clock(_time_machine.original_time_ns)"
)


@dataclass(frozen=True)
class RosEnvironment:
    """Where ROS is and what a child process needs to import it."""

    PORTABLE: ClassVar = "portable"  # a kind of environment
    has_wheels = staticmethod(system.has_ros_wheels)
    system_name = staticmethod(system.name)
    is_tried = staticmethod(system.is_tried)

    kind: str  # "apt", "wheels", "system wheels" or "portable"
    python_path: tuple[Path, ...]  # folders to add to sys.path
    library_path: tuple[Path, ...]  # folders of shared libraries
    prefixes: tuple[Path, ...]  # AMENT_PREFIX_PATH
    prelude: str = ""  # Python that a host runs before virtual time is put under its clocks
    distro: str = DISTRO  # whose it is

    def variables(self) -> dict[str, str]:
        """Return the environment variables of a process that imports rclpy."""
        return {
            "AMENT_PREFIX_PATH": os.pathsep.join(map(str, self.prefixes)),
            "LD_LIBRARY_PATH": os.pathsep.join(map(str, self.library_path)),
            "ROS_DISTRO": self.distro,
            # The wheels' start-up hook would execute Python a second time to set these.
            "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
        }

    @staticmethod
    def portable() -> RosEnvironment:
        """Return the environment of the portable runtime, which needs no ROS (rclpy_portable).

        Raises NoRos: rclpy's Python has to be fetched for it, and can't be.
        """
        try:
            folder = unpacking.folder(_tell)
        except DownloadFailed as error:
            raise NoRos(str(error)) from error
        return RosEnvironment(RosEnvironment.PORTABLE, (folder,), (), (), PORTABLE_PRELUDE)

    @staticmethod
    def find(
        environ: dict[str, str] | None = None, folders: Iterable[Path] | None = None
    ) -> RosEnvironment:
        """Return the ROS 2 installation of this machine.

        Raises NoRos: there is none, or only another one; the message says how to install it.

        Parameters
        ----------
        environ
            Environment variables to look at; the process's own by default.
        folders
            Folders in which the wheels may lie; by default those of this interpreter.
        """
        variables = dict(os.environ) if environ is None else environ
        folders = list(_site_folders() if folders is None else folders)
        found = [ros for ros in (_from_apt(variables), _from_wheels(folders)) if ros is not None]
        for ros in found:
            if ros.distro in GRADED.values():
                return ros
        if found or variables.get("ROS_DISTRO", "") not in ("", *GRADED.values()):
            name = found[0].distro if found else variables["ROS_DISTRO"]
            here = f"ROS 2 {name.capitalize()}" if name.isalpha() else name
            place = f" in {found[0].prefixes[0]}" if found else ""
            advice = BESIDE if system.has_ros_wheels() else f"{NO_WHEELS} {system.name()}"
            raise NoRos(f"{here} is here{place}, expected {_names()}: {advice}", here)
        what, advice = f"ROS 2 {_names()} was not found", HOW_TO_INSTALL
        if name := variables.get("ROS_DISTRO", ""):  # apt's is for the system's Python
            python = f"{sys.version_info.major}.{sys.version_info.minor}"
            what = f"ROS 2 {name.capitalize()} is sourced, but has no rclpy for Python {python}"
            advice = BESIDE
        advice = advice if system.has_ros_wheels() else f"{NO_WHEELS} {system.name()}"
        raise NoRos(f"{what}: {advice}")


def _names() -> str:
    return " or ".join(map(str.capitalize, GRADED.values()))


def _tell(text: str) -> None:
    print(f"course: {text}", file=sys.stderr)


def _distro(folders: Iterable[Path], said: str = "") -> str:
    """Name the ROS of the first rclpy in these folders; an unknown one is what it is `said` to be.

    Without a name, it is "rclpy 8.0".
    """
    folder = next(folder for folder in folders if _has_rclpy(folder))
    names = " ".join(path.name for path in folder.glob("rclpy-*-info"))
    version = re.search(r"rclpy-(\d+\.\d+)", names)
    number = version[1] if version else "?"
    known = GRADED.get(number, "")
    return known or (said if said not in GRADED.values() else "") or f"rclpy {number}"


def _from_apt(environ: dict[str, str]) -> RosEnvironment | None:
    prefixes = [Path(p) for p in environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    paths = [Path(p) for p in environ.get("PYTHONPATH", "").split(os.pathsep) if p]
    if not prefixes or not any(_has_rclpy(path) for path in paths):
        return None
    libraries = [Path(p) for p in environ.get("LD_LIBRARY_PATH", "").split(os.pathsep) if p]
    distro = _distro(paths, environ.get("ROS_DISTRO", ""))
    return RosEnvironment("apt", tuple(paths), tuple(libraries), tuple(prefixes), distro=distro)


def _from_wheels(folders: Iterable[Path]) -> RosEnvironment | None:
    for folder in folders:
        # Debian's pip splits a wheel: its bundled libraries go to dist-packages next door
        bundled = sorted(folder.parent.glob("*-packages/ros_*.libs"))
        if not bundled or not _has_rclpy(folder):
            continue
        prefix = folder.parents[2]  # PREFIX/lib/pythonX.Y/site-packages
        kind = "wheels" if str(folder) in sys.path else "system wheels"
        libraries = (*bundled, prefix / "lib")
        distro = _distro([folder])
        return RosEnvironment(kind, (folder,), libraries, (prefix,), distro=distro)
    return None


def _has_rclpy(folder: Path) -> bool:
    """Return whether this Python can import rclpy from the folder."""
    if not (folder / "rclpy" / "__init__.py").is_file():
        return False  # `dist-packages/rclpy` of the Debian layout is an empty shell
    version = f"{sys.version_info.major}{sys.version_info.minor}"
    return any((folder / "rclpy").glob(f"_rclpy_pybind11.cpython-{version}-*.so"))


def _site_folders() -> list[Path]:
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    candidates = [
        sysconfig.get_path("purelib"),
        sysconfig.get_path("platlib"),
        *site.getsitepackages(),
        f"{sys.prefix}/lib/{version}/site-packages",
        f"{sys.prefix}/local/lib/{version}/site-packages",
        f"/usr/local/lib/{version}/site-packages",
        site.getusersitepackages(),
    ]
    return list(dict.fromkeys(Path(candidate) for candidate in candidates))
