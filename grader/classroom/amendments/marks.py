"""The points of a stored result; or why there are none, and what to do about it."""

import functools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from grader.classroom.row import ABSENT, GRADED, HELD, TWICE, StoredResult, as_graded
from grader.course.exercises import find_exercise
from grader.grading.withheld import for_students, hides_anything
from grader.lms.book import Task
from grader.lms.clean import one_line
from grader.report.facts import UNJUDGED

Check = Mapping[str, Any]

TO_HOLD = ("error", "inconclusive")
PROVISIONAL = "provisional"


@functools.cache
def task_of(name: str) -> Task:
    """Return an exercise, by name or number.

    Raises InputError: it does not exist.
    """
    each = find_exercise(name)
    return Task(each.slug, each.number, each.title, float(each.max_points))


def tasks_of(results: Iterable[StoredResult]) -> list[Task]:
    """Return the exercises of the results, in the order of the lesson."""
    every = map(task_of, {result.exercise for result in results})
    return sorted(every, key=lambda task: task.number)


def as_shown(result: StoredResult, hidden: Collection[str]) -> StoredResult:
    """Return a result as its student may see it; whatever is written for students is made of it."""
    grading = result.grading and for_students(result.grading, result.file_names, hidden)
    if not hides_anything(hidden):
        return replace(result, grading=grading)
    state = HELD if is_held(result) else result.state  # also by a check that isn't shown
    return replace(
        result, grading=grading, state=state, wall_s=0.0, attempts=0, problem="", finished=""
    )


def checks_of(result: StoredResult) -> list[Check]:
    """Return the checks of a result's grading; [] if there is none."""
    return list((result.grading or {}).get("checks") or ())


def is_held(result: StoredResult) -> bool:
    """Return whether a person has to look before this counts."""
    if result.amended is not None and result.amended.by_hand:
        return False
    if result.state == HELD or (result.state == GRADED and result.grading is None):
        return True
    if result.state != GRADED:
        return False
    return any(check.get("outcome") in TO_HOLD for check in checks_of(result))


def is_graded(result: StoredResult) -> bool:
    return result.state == GRADED and not is_held(result)


def is_absent(result: StoredResult) -> bool:
    """Return whether nothing was handed in, which is nobody's fault."""
    return result.state == ABSENT


def is_provisional(result: StoredResult) -> bool:
    """Return whether a score counts that may change yet.

    It does if a core check could not be judged for want of a library, or if no known solution has
    confirmed the grader since.
    """
    if not is_graded(result) or (result.amended is not None and result.amended.by_hand):
        return False
    core = (check for check in checks_of(result) if check.get("kind") != "field")
    return not result.verified or any(check.get("outcome") in UNJUDGED for check in core)


def state_of(result: StoredResult) -> str:
    """Return the state in a word: graded, provisional, held, not handed in, waiting."""
    if is_held(result):
        return HELD
    return PROVISIONAL if is_provisional(result) else result.state


def points_of(result: StoredResult) -> float | None:
    """Return the points in the gradebook; None if there is no score yet.

    Checks that require a library missing on the grading machine don't count: what was judged is
    scaled to the exercise's points, so that no student loses points by it. What a person has
    changed counts before all.
    """
    if result.amended is not None:
        return result.amended.points
    if not is_graded(result) or result.grading is None:
        return None
    score, most = float(result.grading["score"]), float(result.grading["max_score"])
    if most <= 0:
        return None
    return round(min(1.0, max(0.0, score / most)) * task_of(result.exercise).points, 2)


def judged_ones(results: Iterable[StoredResult]) -> list[StoredResult]:
    """Return what the judge said: a check that a person has waived is as hard as it was."""
    return [one for one in map(as_graded, results) if is_graded(one)]


def passed(result: StoredResult) -> str:
    """Say how many core checks passed."""
    core = [check for check in checks_of(result) if check.get("kind") != "field"]
    count = sum(check.get("outcome") == "pass" for check in core)
    return f"{count} of {len(core)} passed" if core else ""


def raw_points(result: StoredResult) -> tuple[float, float, float]:
    """Return the points won, the points that could be won, and those before the cap; unscaled."""
    grading = result.grading or {}
    score = float(grading.get("score") or 0)
    return score, float(grading.get("max_score") or 0), float(grading.get("raw_score", score))


def cap_of(result: StoredResult) -> str:
    """Return why the score is capped; empty if it isn't."""
    return one_line(str((result.grading or {}).get("cap") or ""), 400)


@dataclass(frozen=True)
class Held:
    """Why a grading is held, and what to do about it."""

    reason: str
    action: str


def why_held(result: StoredResult) -> Held:
    """Say, for the instructor, why a result is held and what to do."""
    again = "run the batch again with --retry-held"
    failed = [check for check in checks_of(result) if check.get("outcome") in TO_HOLD]
    errors = [check for check in failed if check.get("outcome") == "error"]
    if errors:
        return Held(
            _first(errors, "The grader itself failed in"),
            "This is not the student's fault. Repair the check, then judge the stored recordings "
            "again with --regrade; no student code runs.",
        )
    if failed and TWICE in result.problem:
        return Held(
            f"{_first(failed, 'The machine stalled during')} So it did when this was judged again, "
            "with nothing beside it.",
            f"If others are held for the same reason, it is the machine: find a quiet one and "
            f"{again}. If not, read the submission first: a node can keep a machine busy on "
            "purpose. Nothing is won by that while you don't enter the points.",
        )
    if failed:
        return Held(_first(failed, "The machine stalled during"), f"On a quiet machine, {again}.")
    if result.problem and not result.file_names:
        return Held(
            one_line(result.problem, 400),
            "Ask for the file, or put it where it belongs, and run the batch again: it grades "
            "only what is new.",
        )
    if result.problem:
        return Held(one_line(result.problem, 400), f"Read the submission first; then {again}.")
    return Held("No result came back.", f"{again[0].upper()}{again[1:]}.")


def so_far(result: StoredResult) -> str:
    """Say what the checks came to that could be judged; "" if there is no grading.

    Out of all points, so that few judged ones don't look like full marks.
    """
    core = [check for check in checks_of(result) if check.get("kind") != "field"]
    most = sum(float(check.get("max_points") or 0) for check in core)
    unjudged = (check for check in core if check.get("outcome") in UNJUDGED)
    left = sum(float(check.get("max_points") or 0) for check in unjudged)
    won = raw_points(result)[0]
    return f"{won:g} of {most:g}, {left:g} not judged" if most else ""


def _first(checks: Sequence[Check], what: str) -> str:
    first = checks[0]
    more = f" and {len(checks) - 1} more" if len(checks) > 1 else ""
    message = one_line(first.get("message") or "", 240)
    title = one_line(first.get("title") or first.get("id") or "a check", 160).rstrip(".")
    return f"{what} “{title}”{more}" + (f": {message}" if message else ".")
