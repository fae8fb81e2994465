"""Errors that the person at the command line can do something about."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from rclpy_virtual_time import DiskFull
from rclpy_virtual_time import EngineError as GraderError  # the grader's fault, or the machine's
from sim.errors import InputError

__all__ = ["DiskFull", "GraderError", "InputError", "is_disk_full", "naming_a_full_disk"]

is_disk_full = DiskFull.caused


@contextlib.contextmanager
def naming_a_full_disk(advice: str) -> Iterator[None]:
    """Raise a `DiskFull` with this advice where a full disk ends the block.

    Raises DiskFull: no space was left.
    """
    try:
        yield
    except Exception as error:
        if not is_disk_full(error):
            raise
        raise DiskFull(advice) from error
