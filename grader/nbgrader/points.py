"""The points of an exercise's checks, as the judge has them."""

from functools import cache

from grader.course.exercises import find_exercise
from grader.grading.grading import grade
from grader.trial.trials import SavedTrials


@cache
def points_of(slug: str) -> dict[str, int]:
    """Return the points of each check that gives any, in the judge's order. No node runs."""
    exercise = find_exercise(slug)
    checks = grade(exercise, SavedTrials([]), file=exercise.files[0]).checks
    return {check.id: check.max_points for check in checks if check.kind == "core"}
