"""What a notebook's first cell says on machines of many kinds, each made here and thrown away.

    sudo .venv/bin/python benchmarks/first_cell.py [--wheel FILE] [--python PYTHON …]

Each layout is a folder with the cell and, in most of them, the course's wheel; the cell runs in a
process of its own. Debian's Python lies in an overlay of /usr without a compiler. `nonet`: in a
network namespace with nothing in it. A real kernel, up to the first check, is bare_notebook.py.
It prints a row for each layout; those with a network download a few hundred megabytes.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from bare_notebook import MOUNT, PYTHON, ROOT, bare_environment, wheel, why_not

sys.path.insert(0, str(ROOT))
from grader.notebook.bootstrap import BOOTSTRAP, SOURCE

LIMIT = 900  # [s] of one cell
HIDE_COMPILERS = "rm -f /usr/bin/*gcc* /usr/bin/*g++* /usr/bin/cc /usr/bin/c++; "
NOBODY = "setpriv --reuid=65534 --regid=65534 --clear-groups "


@dataclass(frozen=True)
class Layout:
    """Where the cell runs, and where the wheel is."""

    name: str
    wheel: str = "."  # folder, relative to the layout's; "": there is none
    nonet: bool = False
    nobody: bool = False  # as an ordinary user
    address: str = ""  # given to `course release --source`


DEBIAN = (
    Layout("Colab: Debian's Python, as root, the wheel uploaded"),
    Layout("Colab, no wheel", wheel=""),
    Layout("Colab, no network", nonet=True),
    Layout("Kaggle: the wheel among the inputs", wheel="kaggle/input/course"),
    Layout("Kaggle, internet off", wheel="kaggle/input/course", nonet=True),
    Layout("JupyterHub: Debian's Python, an ordinary user", nobody=True),
    Layout(
        "an address that nobody serves",
        wheel="",
        address="http://127.0.0.1:9/rclpy_agents_course-0.1.0-py3-none-any.whl",
    ),
)


def main() -> int:
    """Run the layouts; print a row for each."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--wheel", type=Path, help="by default one of this tree")
    parser.add_argument("--python", nargs="*", default=[], help="others, each in a fresh venv")
    parser.add_argument("--only", default="", help="layouts with this in their names")
    options = parser.parse_args()
    if problem := why_not():
        print(f"first_cell: can't run here: {problem}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="first-cell-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        built = options.wheel or wheel(folder)
        print("| Layout | Seconds | What the cell said |\n|---|---|---|")
        for number, layout in enumerate(DEBIAN):
            if options.only in layout.name:
                row(layout.name, debian(folder / str(number), layout, built.resolve()))
        for number, python in enumerate(options.python):
            for nonet in (True, False):
                about = f"a venv of {python}{', no network' if nonet else ''}"
                if options.only in about:
                    row(about, venv(folder / f"venv-{number}-{nonet}", python, nonet, built))
    return 0


def row(name: str, said: tuple[float, str]) -> None:
    """Print a row of the table."""
    print(f"| {name} | {said[0]:.0f} | {said[1]} |", flush=True)


def debian(folder: Path, layout: Layout, built: Path) -> tuple[float, str]:
    """Run the cell on the system's Python, in an overlay."""
    lay_out(folder, layout, built)
    inputs = folder / "kaggle" / "input"
    inputs.mkdir(parents=True, exist_ok=True)
    if layout.wheel.startswith("kaggle"):  # the cell looks into /kaggle: here the folder's own
        cell = (folder / "cell.py").read_text("utf-8")
        (folder / "cell.py").write_text(cell.replace("/kaggle/", f"{folder}/kaggle/"), "utf-8")
    command = f"{NOBODY if layout.nobody else ''}{PYTHON} cell.py"
    inside = ["bash", "-c", MOUNT, str(folder), "bash", "-c", HIDE_COMPILERS + "exec " + command]
    return run(["unshare", "--mount", *(["--net"] if layout.nonet else []), *inside], folder)


def venv(folder: Path, python: str, nonet: bool, built: Path) -> tuple[float, str]:
    """Run the cell in a fresh environment of another Python."""
    lay_out(folder, Layout("venv"), built)
    subprocess.run([python, "-m", "venv", str(folder / "venv")], check=True)
    own = [str(folder / "venv" / "bin" / "python"), "cell.py"]
    return run(["unshare", "--net", *own] if nonet else own, folder)


def lay_out(folder: Path, layout: Layout, built: Path) -> None:
    """Write the cell, and lay the wheel where the layout has it."""
    folder.mkdir()
    folder.chmod(0o777)
    known = f'"{layout.address}"'
    cell = BOOTSTRAP.replace(SOURCE.format(address='""'), SOURCE.format(address=known))
    (folder / "cell.py").write_text(cell, "utf-8")
    if layout.wheel:
        (folder / layout.wheel).mkdir(parents=True, exist_ok=True)
        shutil.copy(built, folder / layout.wheel)


def run(command: list[str], folder: Path) -> tuple[float, str]:
    """Return how long a command took [s], and the last line that it printed."""
    began = time.monotonic()
    done = subprocess.run(
        command, cwd=folder, env=bare_environment() | {"HOME": str(folder)}, timeout=LIMIT,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    last = lines[-1] if lines else "nothing"
    return time.monotonic() - began, last.removeprefix("__main__.").replace(str(folder), "…")


if __name__ == "__main__":
    sys.exit(main())
