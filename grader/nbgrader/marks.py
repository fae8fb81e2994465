"""Turn the judge's verdict into the points of one test cell."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from grader.course.exercises import find_exercise
from grader.course.score import score_of
from grader.nbgrader.cells import Wanted
from grader.nbgrader.judge import Verdict
from grader.report.facts import UNJUDGED, cause_of


@dataclass(frozen=True)
class Mark:
    """The points of one test cell."""

    points: float | None  # None: nothing could be judged
    by_hand: bool  # a person has to look
    checks: tuple[dict[str, Any], ...] = ()
    said: str = ""  # in place of checks
    cause: tuple[tuple[str, str], ...] = ()  # of what failed here, as lines (name, text)


def mark_of(asked: Wanted, verdict: Verdict, max_points: float) -> Mark:
    """Return the mark of a cell that asks for these checks.

    The checks' points come from the judge. If the instructor gave the cell another maximum, they
    are scaled to it.
    """
    if verdict.grading is None:
        return Mark(None, True, said=f"could not be judged: {verdict.problem}")
    checks = _chosen(asked, verdict.grading["checks"])
    possible = sum(check["max_points"] for check in checks)
    won = sum(check["points"] for check in checks)
    by_hand = any(check["outcome"] in UNJUDGED for check in checks)
    if not possible or all(check["outcome"] in UNJUDGED for check in checks):
        return Mark(
            None, True, tuple(checks), "" if checks else "none of its checks exist any more"
        )
    result = score_of(verdict.grading["checks"], find_exercise(asked.exercise).essential)
    won *= result.share  # nbgrader adds up the cells' points, so those of a capped score are scaled
    points = float(won) if possible == max_points else max_points * won / possible
    failed = any(check["outcome"] == "fail" for check in checks)
    cause = tuple(cause_of(verdict.grading)) if failed else ()
    return Mark(points, by_hand, tuple(checks), said=result.note, cause=cause)


def _chosen(asked: Wanted, checks: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    if not asked.checks:
        return [check for check in checks if check["kind"] == "core"]
    by_id = {check["id"]: check for check in checks}
    return [by_id[name] for name in asked.checks if name in by_id]
