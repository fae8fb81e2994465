"""The score of an exercise: the points of its checks, capped while an essential one fails.

Points are for tasks. Above them stands `[essential]` of `exercise.toml`: the point of the exercise,
and the checks whose failure could hurt somebody.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from grader.course.exercises import Essential

HOLDS = ("fail", "skip")  # outcomes of an essential check that cap the score
UNJUDGED = ("error", "inconclusive", "unavailable")  # neither won nor lost


@dataclass(frozen=True)
class Score:
    """The points of a grading, and the cap."""

    raw: float  # points of the checks
    most: float  # that could be won: checks that could not judge are left out
    points: float  # after the cap
    note: str = ""  # why the score is capped; empty if it isn't

    @property
    def share(self) -> float:
        """The share of each check's points that the cap leaves, for platforms without a total."""
        return self.points / self.raw if self.raw else 1.0


def score_of(checks: Iterable[Mapping[str, Any]], essential: Essential | None) -> Score:
    """Return the score of the checks, given as `CheckResult.as_dict` has them.

    What a person has waived does not hold the cap.
    """
    core = [check for check in checks if check.get("kind") != "field"]
    counted = [check for check in core if check.get("outcome") not in UNJUDGED]
    raw = sum(float(check.get("points") or 0) for check in counted)
    most = sum(float(check.get("max_points") or 0) for check in counted)
    if essential is None:
        return Score(raw, most, raw)
    held_by = (check for check in counted if check.get("id") in essential.checks)
    failed = [c for c in held_by if c.get("outcome") in HOLDS and not c.get("waived")]
    cap = essential.cap * most // 100
    if not failed or raw <= cap:
        return Score(raw, most, raw)
    titles = " and ".join(f"“{str(check.get('title')).rstrip('.')}”" for check in failed[:2])
    note = (
        f"At most {cap:g} of {most:g} points until this passes: {titles}. {essential.why} "
        f"Before this cap: {raw:g} points."
    )
    return Score(raw, most, cap, note)
