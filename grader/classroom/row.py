"""One row of a graded class: what the batch stores and everything after it reads."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

WAITING: Final = "waiting"
RUNNING: Final = "running"
GRADED: Final = "graded"
HELD: Final = "held"  # a person has to look before it counts
ABSENT: Final = "not handed in"  # no fault of anybody's, and nobody has to look

# Parts of a `problem`
UNJUDGED: Final = "could not judge"
STALLS: Final = "the machine stalled"
TWICE: Final = "judged twice, the second time with nothing beside it"


@dataclass(frozen=True)
class StoredResult:
    """One student, one exercise."""

    student: str  # a safe name for a folder, made by intake
    exercise: str  # slug
    file_names: tuple[str, ...]  # the files that were graded, as the exercise names them
    input_hash: str  # SHA-256 of all that the grading depends on
    state: str  # one of these
    grading: dict[str, Any] | None  # `Grading.as_dict()`; None while there is none
    recordings: Path | None  # a folder of bags
    wall_s: float  # [s]
    attempts: int
    problem: str  # why it is held or could not be graded; "" if neither
    finished: str  # UTC, ISO 8601; "" while unfinished
    verified: bool = True  # the known solutions came out right after it, if there are any
    amended: Amended | None = None  # what a person has changed; never stored

    @property
    def key(self) -> tuple[str, str]:
        """What the store calls it."""
        return self.student, self.exercise


@dataclass(frozen=True)
class Amended:
    """What a person has changed in a result, and what it came to."""

    points: float | None  # that count, out of the exercise's; None: there are none
    steps: tuple[str, ...]  # in words, for the student, too
    entries: tuple[int, ...]  # of the log
    by_hand: bool  # a person's own score, whatever was graded
    graded: StoredResult  # as the judge made it
    style: tuple[float, float] | None = None  # points for style, and out of how many; beside these
    only_words: bool = False  # for the student to read; the points are the judge's


def as_graded(result: StoredResult) -> StoredResult:
    """Return the result as the judge made it, without what a person has changed."""
    return result if result.amended is None else result.amended.graded
