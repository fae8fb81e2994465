"""Errors that the person at the command line can do something about."""

from __future__ import annotations

from sim.errors import InputError

__all__ = ["GraderError", "InputError"]


class GraderError(Exception):
    """The fault of the grader or the machine; it costs a student nothing."""
