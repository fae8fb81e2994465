"""What was handed out is no work: skeletons, and the rest of the course's own files."""

from functools import cache
from pathlib import Path

from grader.course.exercises import ROOT, all_exercises
from grader.course.submission import read_regular_file

HANDED_OUT = (  # folders with Python
    "exercises", "lessons", "grader", "sim", "rclpy_virtual_time", "rclpy_portable",
)  # fmt: skip


def bare(text: str) -> str:
    """Return a program without blanks, empty lines and comments, for comparison.

    A "#" in a string ends its line, too: the text is a student's, and nobody parses it here.
    """
    lines = ("".join(line.partition("#")[0].split()) for line in text.splitlines())
    return "\n".join(filter(None, lines))


@cache
def skeletons() -> dict[str, str]:
    """Return the bare text of each exercise's Python as students get it, by the file's name."""
    return {
        name: bare((exercise.folder / name).read_text("utf-8"))
        for exercise in all_exercises()
        for name in exercise.files
        if (exercise.folder / name).is_file()
    }


def is_skeleton(path: Path, name: str) -> bool:
    """Return whether a file is what was handed out under that name, but for comments."""
    return name in skeletons() and _bare_of(path) == skeletons()[name]


def is_empty(path: Path) -> bool:
    """Return whether nothing is in a file but blanks."""
    try:
        return not read_regular_file(path).strip()
    except OSError:
        return False


def is_handed_out(path: Path) -> bool:
    """Return whether a file is any Python of the course's, but for comments, or comments alone."""
    return not (text := _bare_of(path)) or text in _course()


@cache
def _course() -> frozenset[str]:
    files = (path for folder in HANDED_OUT for path in (ROOT / folder).rglob("*.py"))
    return frozenset(bare(path.read_text("utf-8")) for path in files)


def _bare_of(path: Path) -> str:
    try:
        return bare(read_regular_file(path).decode("utf-8", "replace"))
    except OSError:
        return "?"  # no file of the course's
