"""A student's submission: find the files, and check what can be checked without running them."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.errors import InputError
from grader.link.scratch import fresh_folder

MAX_SIZE = 1024 * 1024  # [bytes] of a student's file


@dataclass(frozen=True)
class Submission:
    """A node's file, and the reason why it can't be run, if there is one."""

    path: Path
    problem: str = ""  # the student's mistake, found before the run; "" if none
    others: tuple[Path, ...] = ()  # the exercise's other files, beside it

    @contextlib.contextmanager
    def folder(self) -> Iterator[Path]:
        """Copy the files into a fresh folder, whose owner may be changed."""
        with fresh_folder() as folder:
            for path in (self.path, *self.others):
                shutil.copyfile(path, folder / path.name)
            yield folder


def find_submission(
    path: Path, expected: str | None = None, others: Sequence[str] = ()
) -> Submission:
    """Return the submission at `path`: a file, or a folder that holds the file `expected`.

    The exercise's other files beside it belong to the submission. If an exercise has several files
    (`expected` and `others`), `path` may be any of them.

    Raises
    ------
    InputError
        There is no such file.
    """
    if path.is_dir():
        path = _in_folder(path, expected)
    elif not path.exists():
        raise InputError(f"{path}: no such file; expected a Python file or a folder with one")
    elif not path.is_file():
        raise InputError(f"{path}: expected a Python file, but this is not a regular file")
    if expected and path.name in others:
        others = [expected, *others]
    beside = [path.with_name(name) for name in dict.fromkeys(others) if name != path.name]
    found = tuple(other.resolve() for other in beside if other.is_file())
    problems = [_problem(file) for file in (path, *found)]
    return Submission(path.resolve(), next(filter(None, problems), ""), found)


def read_regular_file(path: Path, limit: int = MAX_SIZE) -> bytes:
    """Return the first `limit` + 1 bytes of a file that somebody handed in; no link is followed.

    Raises
    ------
    OSError
        It can't be read, or is not a regular file.
    """
    fd = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with open(fd, "rb") as file:
        if not stat.S_ISREG(os.fstat(fd).st_mode):
            raise OSError(0, "not an ordinary file", str(path))
        return file.read(limit + 1)


def _in_folder(folder: Path, expected: str | None) -> Path:
    if expected is None:
        raise InputError(f"{folder}: expected a Python file, but this is a folder")
    path = folder / expected
    if not path.is_file():
        there = sorted(file.name for file in folder.glob("*.py"))[:5]
        found = f"it holds {', '.join(there)}" if there else "it holds no Python file"
        raise InputError(f"{folder}: expected a file {expected} in this folder; {found}")
    return path


def _problem(path: Path) -> str:
    if not path.name.isprintable():  # not UTF-8, or with control characters
        raise InputError(f"{str(path)!r}: give the file a name of ordinary characters")
    try:
        size = path.stat().st_size
        if size > MAX_SIZE:
            return f"the file has {size:,} bytes; at most {MAX_SIZE:,} are read"
        if not path.read_bytes().strip():
            return "the file is empty"
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    return ""
