"""What an exercise's own `causes.py` sees in the recordings, if it has one."""

from __future__ import annotations

import importlib
from collections.abc import Sequence

from grader.checks.verdict import Evidence
from grader.course.exercises import Exercise
from grader.grading.causes.cause import ByName, Cause, Failed, hint_at, place_of


def cause_of_exercise(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return the cause that the exercise's own `causes.py` finds."""
    if not (exercise.judge / "causes.py").is_file():
        return None
    module = importlib.import_module(f"grader.exercises.{exercise.slug}.causes")
    found: Evidence | None = module.seen(trials, [check.id for check in failed])
    if found is None:
        return None
    explained = [check for check in failed if check.id in found.explains]
    hint = hint_at(exercise, place_of(found.hint)) if found.hint else None
    return Cause.of(
        exercise, found.text, explained or failed[:1], hint=hint, replaces_help=True, own_hint=False
    )
