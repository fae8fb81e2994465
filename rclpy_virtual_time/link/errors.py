"""Errors of the engine: they are the machine's fault or the caller's, never the program's."""

from __future__ import annotations

import errno

SQLITE_FULL = (13, 4874)  # https://sqlite.org/rescode.html#full and #ioerr_shmsize
NO_SPACE = (errno.ENOSPC, errno.EDQUOT)


class EngineError(Exception):
    """The fault of the engine or the machine; the program that was to run has none."""


class NoRos(EngineError):
    """There is no ROS 2, or only one (`here`, by its name) that virtual time was not made for."""

    def __init__(self, said: str, here: str = "") -> None:
        super().__init__(said)
        self.here = here


class DiskFull(EngineError):
    """No space is left where the engine writes."""

    @staticmethod
    def caused(error: BaseException | None) -> bool:
        """Return whether a full disk has caused an error, or the error that caused it."""
        seen: set[int] = set()
        while error is not None and id(error) not in seen:
            seen.add(id(error))
            if isinstance(error, DiskFull):
                return True
            if isinstance(error, OSError) and error.errno in NO_SPACE:
                return True
            if getattr(error, "sqlite_errorcode", None) in SQLITE_FULL:
                return True
            error = error.__cause__ or error.__context__
        return False
