"""Write the table of checks in each exercise's README, from the checks themselves.

It stands between `<!-- table of checks -->` and `<!-- end of table -->`. `python -m
grader.authoring.tables` writes it, `--check` only compares.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

from grader.course.exercises import Exercise, all_exercises
from grader.course.generated import write_or_check
from grader.errors import InputError
from grader.grading.grading import grade
from grader.trial.trials import SavedTrials

BEGIN, END = "<!-- table of checks -->", "<!-- end of table -->"
PLACE = re.compile(f"{re.escape(BEGIN)}\n.*?{re.escape(END)}\n", re.DOTALL)
HEAD = "| Check | Task | Points | What it asks |\n|---|---|---|---|\n"


def readmes() -> Iterator[tuple[Path, str]]:
    """Yield (path, text) of every README.

    Raises
    ------
    InputError
        One has no place for the table.
    """
    for exercise in all_exercises():
        path = exercise.folder / "README.md"
        text = path.read_text("utf-8")
        if len(PLACE.findall(text)) != 1:
            raise InputError(f"{path}: expected one table between {BEGIN} and {END}")
        before, after = text.partition(BEGIN)[0], text.partition(f"{END}\n")[2]
        yield path, before + table(exercise) + after


def table(exercise: Exercise) -> str:
    """Return the table of an exercise's core checks, with the comments around it."""
    checks = grade(exercise, SavedTrials([]), file=exercise.files[0]).checks
    rows = (
        f"| `{check.id}` | {check.task or 'all'} | {check.max_points} | {check.title} |\n"
        for check in checks
    )
    total = sum(check.max_points for check in checks)
    return f"{BEGIN}\n{HEAD}{''.join(rows)}| | | **{total}** | |\n{END}\n"


def main(arguments: list[str]) -> int:
    """Write the tables, or with `--check` compare them."""
    return write_or_check(readmes(), "python -m grader.authoring.tables", arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
