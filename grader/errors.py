"""Errors that the person at the command line can do something about."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Iterator

from sim.errors import InputError

__all__ = ["DiskFull", "GraderError", "InputError", "is_disk_full", "naming_a_full_disk"]

SQLITE_FULL = 13  # https://sqlite.org/rescode.html#full
NO_SPACE = (errno.ENOSPC, errno.EDQUOT)


class GraderError(Exception):
    """The fault of the grader or the machine; it costs a student nothing."""


class DiskFull(GraderError):
    """No space is left where the grader writes."""


def is_disk_full(error: BaseException | None) -> bool:
    """Return whether a full disk has caused an error, or the error that caused it."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        if isinstance(error, DiskFull):
            return True
        if isinstance(error, OSError) and error.errno in NO_SPACE:
            return True
        if getattr(error, "sqlite_errorcode", None) == SQLITE_FULL:
            return True
        error = error.__cause__ or error.__context__
    return False


@contextlib.contextmanager
def naming_a_full_disk(advice: str) -> Iterator[None]:
    """Raise a `DiskFull` with this advice where a full disk ends the block.

    Raises
    ------
    DiskFull
        No space was left.
    """
    try:
        yield
    except Exception as error:
        if not is_disk_full(error):
            raise
        raise DiskFull(advice) from error
