"""What lies in a node's folder and comes along: its modules, parameters, models, other data.

A folder may be anybody's home, so there are limits. Python comes before data and what lies near
before what lies deep; no link is followed. What stays behind is said.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

MAX_FILES = 200
MAX_BYTES = 64 * 1024 * 1024  # of all together
MAX_PYTHON = 1024 * 1024  # [bytes] of a Python file
MAX_DEPTH = 6  # folders below
MAX_LISTED = 5_000  # names that are looked at
MAX_NAME = 200  # [characters] of a path
NAMED = 4  # files in a sentence

NOT_THEIRS = {"__MACOSX", "__pycache__", "node_modules", "venv", "site-packages"}
MADE = ("COLCON_IGNORE", "pyvenv.cfg")  # in colcon's build, install and log; in an environment
OURS = {"mutants.diff", "design.md"}  # beside a solution of the course's own
COURSE = ("grader", "sim", "rclpy_virtual_time", "rclpy_portable")  # where it lies there itself
ITSELF = Path("grader") / "course" / "beside.py"
SETUP, MANIFEST = "setup.py", "package.xml"
MANUALS = (".md", ".rst")  # read by a setup.py beside them, for `long_description`
READ_BY_NOBODY = (".pdf", ".html", ".ipynb", ".zip", ".tar", ".tgz", ".mcap", ".db3")
PYTHON = (".py", ".pyw")


@dataclass(frozen=True)
class Beside:
    """The accompanying files, by path below the folder, and what is left out."""

    files: dict[str, Path]
    left: tuple[str, ...] = ()  # "data.bin (a link)"
    over: tuple[str, ...] = ()  # names beyond the limits


@dataclass(frozen=True)
class Lying:
    """A file that may come along."""

    name: str  # its path below the folder, with slashes
    path: Path
    size: int  # [bytes]


def beside(folder: Path, first: str = "") -> Beside:
    """Return the accompanying files of a node in a folder; those of a package in it come first."""
    links: list[str] = []
    there = list(_listed(folder, links))
    return chosen(there, links, first)


def chosen(there: Iterable[Lying], links: Iterable[str] = (), first: str = "") -> Beside:
    """Return the accompanying files among these, those below a folder before the others."""
    files: dict[str, Path] = {}
    left, over, size = list[str](), [], 0
    there = sorted(there, key=_rank)
    there.sort(key=lambda each: not each.name.startswith(f"{first}/"))
    setups = {PurePosixPath(each.name).parent for each in there if each.name.endswith(SETUP)}
    for each in there:
        python = each.name.endswith(PYTHON)
        if not may_come(each.name, manual=PurePosixPath(each.name).parent in setups):
            continue
        if len(files) == MAX_FILES or size + each.size > MAX_BYTES:
            over.append(each.name)
        elif python and each.size > MAX_PYTHON:
            left.append(f"{each.name} (over {MAX_PYTHON:,} bytes)")
        else:
            files[each.name] = each.path
            size += each.size
    if over:
        limits = f"{MAX_FILES} files, {MAX_BYTES >> 20} MiB in all"
        left.append(f"{listed(over)} (over the limits: {limits})")
    if links := [name for name in links if name.isprintable()]:
        left.append(f"{listed(links)} (links are not followed)")
    return Beside(files, tuple(left[-NAMED:]), tuple(over))


def may_come(name: str, *, manual: bool = False) -> bool:
    """Return whether a node may want a file of this path; `manual`: also one to be read."""
    parts = PurePosixPath(name).parts
    if not name.isprintable() or len(name) > MAX_NAME or any(map(is_hidden, parts)):
        return False
    return not name.lower().endswith(READ_BY_NOBODY if manual else (*MANUALS, *READ_BY_NOBODY))


def is_hidden(name: str) -> bool:
    """Return whether the name is hidden or generated (.git, __pycache__, venv)."""
    return name.startswith(".") or name in NOT_THEIRS


def listed(names: Iterable[str]) -> str:
    """Return the first few names, for a sentence."""
    every = list(names)
    more = len(every) - NAMED
    return ", ".join(every[:NAMED]) + (f" and {more} more" if more > 0 else "")


def _rank(each: Lying) -> tuple[bool, int, str]:
    return not each.name.endswith((*PYTHON, MANIFEST)), each.name.count("/"), each.name


def _listed(top: Path, links: list[str]) -> Iterator[Lying]:
    """Yield the files below a folder, those near the top first; note the links."""
    pending, seen = [(top, "")], 0
    while pending:
        folder, prefix = pending.pop(0)
        try:
            with os.scandir(folder) as found:
                entries = sorted(found, key=lambda entry: entry.name)
                if (folder / ITSELF).is_file():
                    entries = [entry for entry in entries if entry.name not in COURSE]
        except OSError:
            continue
        names = {entry.name for entry in entries}
        if prefix and not names.isdisjoint(MADE):
            continue
        if names >= OURS:
            entries = [entry for entry in entries if entry.name.endswith(PYTHON)]
        for entry in entries:
            seen += 1
            if seen > MAX_LISTED:
                return
            if is_hidden(entry.name):
                continue
            name = prefix + entry.name
            if entry.is_symlink():
                links.append(name)
            elif entry.is_dir(follow_symlinks=False) and name.count("/") < MAX_DEPTH:
                pending.append((Path(entry.path), f"{name}/"))
            elif entry.is_file(follow_symlinks=False):
                yield Lying(name, Path(entry.path), entry.stat(follow_symlinks=False).st_size)
