"""A student's submission: find the files, and check what can be checked without running them.

All files that somebody handed in are read here, and no link is followed: it may lead to another
student's answer, or to the instructor's files. Only the file that a person names on the command
line may be a link, since it is that person's own.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

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
                (folder / path.name).write_bytes(read_regular_file(path))
            yield folder


def find_submission(
    path: Path, expected: str | None = None, others: Sequence[str] = ()
) -> Submission:
    """Return the submission at `path`: a file, or a folder that holds the file `expected`.

    The exercise's other files beside it belong to the submission. If an exercise has several files
    (`expected` and `others`), `path` may be any of them. `path` itself may be a link; what is
    found in a folder or beside it may not.

    Raises
    ------
    InputError
        There is no such file, or one is a link.
    """
    if path.is_dir():
        path = _in_folder(path, expected)
    elif not path.exists():
        raise InputError(f"{path}: no such file; expected a Python file or a folder with one")
    elif not path.is_file():
        raise InputError(f"{path}: expected a Python file, but this is not a regular file")
    if expected and path.name in others:
        others = [expected, *others]
    names = [name for name in dict.fromkeys(others) if name != path.name]
    found = tuple(file for name in names if (file := file_beside(path, name)) is not None)
    path = path.resolve()
    problems = [_problem(file) for file in (path, *found)]
    return Submission(path, next(filter(None, problems), ""), found)


def file_beside(path: Path, name: str) -> Path | None:
    """Return the file called `name` beside `path`; None if there is none.

    Raises
    ------
    InputError
        It is a link.
    """
    file = path.parent.resolve() / name
    if file.is_symlink():
        raise InputError(
            f"{path.with_name(name)}: a link, which is not followed, since it may lead to "
            "somebody else's file; expected the file itself"
        )
    return file if file.is_file() else None


def read_regular_file(path: Path, limit: int = MAX_SIZE) -> bytes:
    """Return the first `limit` + 1 bytes of a file that somebody handed in; no link is followed.

    Raises
    ------
    OSError
        It can't be read, or is not a regular file.
    """
    with open_regular_file(path) as file:
        return file.read(limit + 1)


def open_regular_file(path: Path) -> BinaryIO:
    """Open a file that somebody handed in, or that a student's program wrote.

    Raises
    ------
    OSError
        It can't be read, is a link, or is not a regular file.
    """
    fd = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(fd).st_mode):
        os.close(fd)
        raise OSError(0, "not an ordinary file", str(path))
    return open(fd, "rb")


def _in_folder(folder: Path, expected: str | None) -> Path:
    if expected is None:
        raise InputError(f"{folder}: expected a Python file, but this is a folder")
    path = folder / expected
    if file_beside(path, expected) is None:
        there = sorted(file.name for file in folder.glob("*.py"))[:5]
        found = f"it holds {', '.join(there)}" if there else "it holds no Python file"
        raise InputError(f"{folder}: expected a file {expected} in this folder; {found}")
    return path


def _problem(path: Path) -> str:
    if not path.name.isprintable():  # not UTF-8, or with control characters
        raise InputError(f"{str(path)!r}: give the file a name of ordinary characters")
    try:
        content = read_regular_file(path)
        if len(content) > MAX_SIZE:
            size = path.stat().st_size
            return f"the file has {size:,} bytes; at most {MAX_SIZE:,} are read"
        if not content.strip():
            return "the file is empty"
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    return ""
