"""`prepare`: make a running kernel ready for the course, without a restart.

On Debian, Ubuntu and Colab the kernel may be the system Python. pip then puts ROS into
`/usr/local/lib/pythonX.Y/site-packages`, which is not on `sys.path`, while empty folders of the
same names are.

Only the standard library is imported here until everything is installed.
"""

import importlib
import os
import re
import sys
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path

from grader.course.installed import COURSE, never_run
from grader.notebook.program import run
from grader.notebook.show import Progress
from rclpy_virtual_time import NoRos, RosEnvironment

ROOT = Path(__file__).resolve().parents[2]
CONSTRAINTS = ROOT / "constraints.txt"
PATHS = ("AMENT_PREFIX_PATH", "LD_LIBRARY_PATH")  # extended, not replaced
LAST_LINES = 6  # of pip's output
WHYS = {  # what pip says: what to do
    "externally-managed-environment": "this Python belongs to the operating system. Make a virtual "
    "environment (python3 -m venv .venv), install the course in it, and start Jupyter from there",
    "No module named pip": "pip is missing: install it (apt install python3-pip), and run the cell "
    "again",
}


def prepare_kernel() -> None:
    """See `grader.notebook.prepare`."""
    if sys.platform == "emscripten":
        from grader.notebook import page  # noqa: PLC0415  (it is there already)

        print(page.why_not() or page.READY, flush=True)
        return
    wanted = missing()
    if wanted and not _install(wanted):
        return
    importlib.invalidate_caches()
    try:
        ros = _ros()
    except NoRos as error:
        print(f"Not ready: {error}", flush=True)
        return
    adopt(ros)
    said = f"Ready: {'installed ' + ', '.join(wanted) if wanted else 'everything is installed'}"
    print(f"{said}.", flush=True)
    if ros.kind == RosEnvironment.PORTABLE:
        from rclpy_virtual_time import PracticeServer  # noqa: PLC0415  (needs what is installed now)

        words = PracticeServer.words()
        said = f"{words[0].upper()}{words[1:]}. {never_run()}"
        print(said.strip(), flush=True)


def _ros() -> RosEnvironment:
    """Return the real ROS, or the portable one where there are no wheels of the real one."""
    try:
        return RosEnvironment.find()
    except NoRos as error:
        if RosEnvironment.has_wheels() and not error.here:
            raise
        return RosEnvironment.portable()


def missing() -> list[str]:
    """Return the requirements of a notebook that this Python lacks."""
    wanted = [one for one in (*required(), *required("ml"), "matplotlib") if not _is_here(one)]
    try:
        RosEnvironment.find()
    except NoRos as error:  # its wheels would take the place of another ROS's
        wanted += required("ros") if RosEnvironment.has_wheels() and not error.here else []
    return wanted


def required(extra: str = "") -> list[str]:
    """Return the course's requirements, or those of one of its extras: pyproject.toml's."""
    try:
        parts = [line.partition(";") for line in metadata.requires(COURSE) or ()]
    except metadata.PackageNotFoundError:
        return []  # a checkout on the path: whoever put it there knows what it needs
    wanted = rf"extra == .{extra}['\"]" if extra else "^(?!.*extra)"
    return [name.strip() for name, _, marker in parts if re.search(wanted, marker)]


def _is_here(requirement: str) -> bool:
    try:
        metadata.version(re.split(r"[^\w.-]", requirement)[0])
    except metadata.PackageNotFoundError:
        return False
    return True


def adopt(ros: RosEnvironment) -> None:
    """Make ROS findable for the processes that this kernel starts, with its own path."""
    for folder in map(str, ros.python_path):
        if folder not in sys.path:
            sys.path.append(folder)  # a real package there precedes any empty folder
    for name, value in ros.variables().items():
        before = os.environ.get(name, "") if name in PATHS else ""
        parts = filter(None, [*value.split(os.pathsep), *before.split(os.pathsep)])
        os.environ[name] = os.pathsep.join(dict.fromkeys(parts))
    importlib.invalidate_caches()


def _install(wanted: Sequence[str]) -> bool:
    """Install distributions with pip; if that fails, say why."""
    bar = Progress(f"Installing {', '.join(wanted)}")
    try:
        code, said = run(pip_command(wanted), bar, pip_environment(os.environ))
    except BaseException:
        bar.say("Not ready: pip was stopped. Run the cell again.")
        raise
    bar.say(_why_not(said) if code else f"Installed {', '.join(wanted)}.")
    return code == 0


def pip_command(wanted: Sequence[str]) -> list[str]:
    """Return pip's command line, with the course's versions if they are known here."""
    pinned = ["--constraint", str(CONSTRAINTS)] if CONSTRAINTS.is_file() else []
    return [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check",
            *pinned, *wanted]  # fmt: skip


def pip_environment(environ: Mapping[str, str]) -> dict[str, str]:
    """Return pip's environment.

    The Python of Debian and Ubuntu refuses pip, to protect the system. A notebook that runs as root
    runs on a throw-away machine, such as a cloud notebook or a container.
    """
    root = {"PIP_BREAK_SYSTEM_PACKAGES": "1", "PIP_ROOT_USER_ACTION": "ignore"}
    is_root = hasattr(os, "getuid") and os.getuid() == 0
    return {**(root if is_root else {}), **environ}


def _why_not(said: str) -> str:
    known = (advice for words, advice in WHYS.items() if words in said)
    if (advice := next(known, None)) is not None:
        return f"Not ready: {advice}."
    lines = [line for line in said.strip().splitlines() if line.strip()][-LAST_LINES:]
    advice = "Not ready: pip could not install what is missing. It said:"
    return "\n".join([advice, *(f"    {line}" for line in lines)])
