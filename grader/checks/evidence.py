"""What a recording shows of a mistake that an exercise's own checks would only show the effects of.

An exercise may have a `causes.py` with a function `seen(trials, failed)` that returns such a
finding, or None. It says what was seen and when, with every seed, and is silent otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from grader.recording import Recording

Trials = Mapping[str, Recording]  # by the scenario's name


@dataclass(frozen=True)
class Evidence:
    """What was seen."""

    text: str  # a sentence; what may lie behind it is asked
    hint: str = ""  # where it stands in hints.md: task and number, "2.1"
    explains: Sequence[str] = ()  # ids of failed checks whose own help would lead elsewhere
