"""A person's machine: a folder, a terminal in it, an environment with what pip brings.

No variable of the tests is set there, and nothing of the checkout is on the path. Without a network
what pip would bring is taken from the tests' environment: only what the course asks for.
"""

import os
import shutil
import subprocess
import sys
import textwrap
import venv
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import Distribution, distribution, distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[2]
COURSE = "rclpy-agents-course"
MadeOnce = Callable[[str, Callable[[Path], object]], Path]  # of tests/conftest.py
PATIENCE = 1800  # [s] of a line, on a busy machine


@dataclass(frozen=True)
class Person:
    """Somebody at a terminal. A virtual environment is activated."""

    home: Path
    environment: Path | None = None

    def types(self, line: str, code: int = 0, before: str = "") -> str:
        """Return what a line printed; it has to end with this code."""
        if line.startswith("unzip ") and shutil.which("unzip") is None:
            pytest.skip("there is no unzip on this machine")
        places = [
            f"{p}/bin" for p in (self.environment, sys.base_prefix, "/usr/local", "/usr") if p
        ]
        path = ":".join([*places, "/bin"])
        done = subprocess.run(
            [*before.split(), "bash", "-c", line], cwd=self.home, text=True, timeout=PATIENCE,
            env={"HOME": str(self.home), "PATH": path, "LANG": "C.UTF-8", "COLUMNS": "100"},
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip
        assert done.returncode == code, f"{line}: {done.returncode}\n{done.stdout[-6000:]}"
        return done.stdout

    def writes(self, files: Mapping[str, str]) -> None:
        for name, text in files.items():
            (self.home / name).parent.mkdir(parents=True, exist_ok=True)
            (self.home / name).write_text(textwrap.dedent(text).lstrip("\n"), "utf-8")


INSTRUCTOR = Path(sys.prefix)  # the environment of a checkout


def can_mount() -> bool:
    """Tell whether this machine lets us mount: `unshare --mount` before a line."""
    return not subprocess.run(
        ["unshare", "--mount", "true"], capture_output=True, check=False
    ).returncode


def clone(person: Person, name: str) -> Path:
    """Clone the project, with what is changed and not committed."""
    person.types(
        f"git clone --quiet {ROOT} {name}; "
        f"git -C {ROOT} diff HEAD --binary | git -C {name} apply --allow-empty"
    )
    return person.home / name


# --- what pip does, without a network ----------------------------------------------------------


def environment(
    folder: Path, course: str, extras: Collection[str] = ("ros",), more: Collection[str] = ()
) -> Path:
    """Make an environment with the course in it (`course` as for pip), and what that asks for."""
    venv.create(folder, symlinks=True)
    (site,) = folder.glob("lib/python*/site-packages")
    if course:
        lay([Requirement("setuptools")], site)  # which builds it
        pip = [sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install"]
        options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation"]
        subprocess.run([*pip, *options, *course.split()], check=True, timeout=PATIENCE)
        (mine,) = distributions(name=COURSE, path=[str(site)])
    else:
        mine = distribution(COURSE)
    lay([*needs(mine, extras), *map(Requirement, more)], site)
    return folder


def lay(asked: list[Requirement], site: Path) -> None:
    """Put distributions there, with all that they ask for."""
    seen = set()
    while asked:
        each = asked.pop()
        if (each.name, *each.extras) in seen:
            continue
        seen.add((each.name, *each.extras))
        if each.name == "ros-jazzy-rclpy" and not [*distributions(name=each.name)]:
            pytest.skip("needs ROS 2 Jazzy by pip, which is what the course asks for")
        found = distribution(each.name)
        asked += needs(found, each.extras)
        for file in found.files or ():
            _put(Path(str(found.locate_file(file))), Path(os.path.normpath(site / file)))


def needs(of: Distribution, extras: Collection[str]) -> Iterator[Requirement]:
    """Yield what a distribution asks for here, with these extras."""
    for each in map(Requirement, of.requires or ()):
        if each.marker is None or any(each.marker.evaluate({"extra": e}) for e in ("", *extras)):
            yield each


def _put(source: Path, target: Path) -> None:
    if target.exists() or not source.is_file():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.parent.name == "bin":
        first, _, rest = source.read_bytes().partition(b"\n")
        if first.startswith(b"#!") and b"python" in first:  # a program gets another Python
            target.write_bytes(b"#!%s\n%s" % (os.fsencode(target.with_name("python")), rest))
            target.chmod(0o755)
            return
    try:
        os.link(source, target)
    except OSError:  # another file system
        shutil.copy2(source, target)
