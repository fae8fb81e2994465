"""What to do next: from what passed last in each exercise."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grader.course.exercises import Exercise, all_exercises
from grader.exercises import contract_of
from grader.grading.attempts import attempts
from grader.grading.grading import grade
from grader.grading.plugin import CheckResult
from grader.trial.trials import SavedTrials


def onward(exercise: Exercise | None = None) -> list[str]:
    """Return the next steps, in lines, commands indented; of an exercise, or of the last graded."""
    every = all_exercises()
    known = {each.slug: each for each in every if exercise in (None, each)}
    graded = [(known[slug], file) for slug, file in attempts() if slug in known and file.exists()]
    if not graded:
        command = "course start" + (f" {exercise.number}" if exercise else "")
        return ["Nothing has been graded here yet. Begin with", f"  {command}"]
    now, file = graded[-1]
    passed = attempts()[now.slug, file]
    checks = grade(now, SavedTrials([]), file=file.name, field=True).checks
    core = [check for check in checks if check.kind != "field"]
    where = shown(file)
    failed = [check for check in core if passed.get(check.id) is False]
    if left := failed + [check for check in core if check.id not in passed]:
        return _still(now, where, left, len(core))
    if any(passed.get(check.id) is not True for check in checks):
        return [
            f"Exercise {now.number}: all that carries points passes. For the badge, other sensors "
            "and worlds:",
            f"  course grade {now.number} {where} --field",
            *_race(now, where),
            *_another(every, now),
        ]
    return [
        f"Exercise {now.number}: full marks, and field-ready. Does it hold in any world?",
        f"  course search {where} --exercise {now.number}",
        *_race(now, where),
        *_another(every, now),
    ]


def _race(now: Exercise, where: str) -> list[str]:
    if not contract_of(now).race:
        return []
    return ["Does it beat the reference, in three worlds?", f"  course race {now.number} {where}"]


def _still(now: Exercise, where: str, left: Sequence[CheckResult], most: int) -> list[str]:
    first = left[0]
    task = f"task {first.task}" if first.task else "all tasks together"
    return [
        f"Exercise {now.number}: {most - len(left)} of {most} checks pass. Next comes {task}: "
        f"{first.title}",
        f"  course grade {now.number} {where} --only {first.id}",
    ]


def _another(every: Sequence[Exercise], now: Exercise) -> list[str]:
    """Return the next exercise in order that was never graded."""
    begun = {slug for slug, _ in attempts()}
    later = [each for each in every if each.number > now.number and each.slug not in begun]
    if not later:
        return []
    return [f"Or go on: {later[0].title}.", f"  course start {later[0].number}"]


def shown(file: Path) -> str:
    """Return the shortest form of a path from the current folder."""
    here = Path.cwd()
    shown = str(file.relative_to(here)) if file.is_relative_to(here) else str(file)
    return f'"{shown}"' if " " in shown else shown
