"""The progress of a grading, for the person who waits."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

TRIAL, CHECK = "trial", "check"
LEFT_OUT = "left out"  # the outcome of a trial that no check can use


class Step(NamedTuple):
    """A trial that begins or ends, or a check that was judged."""

    what: str  # TRIAL or CHECK
    done: int
    of: int
    name: str  # of the scenario or the check
    outcome: str = ""  # of a check; how a trial ended; "": it begins


OnProgress = Callable[[Step], None]
"""Called from any thread."""


def ignore(step: Step) -> None:
    """Report nothing."""
