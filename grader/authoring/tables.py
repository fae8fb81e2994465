"""Write the table of checks in each exercise's README, from the checks themselves.

It has a row for each task: what should pass when that is done. Below it stands what caps the score.
What a check asks for is said in the tasks, and by the check itself when it is graded. The table
between `<!-- table of checks -->` and `<!-- end of table -->`. `python -m grader.authoring.tables`
writes it, `--check` only compares.
"""

import re
import sys
import textwrap
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from grader.course.exercises import Essential, Exercise, all_exercises
from grader.course.generated import write_or_check
from grader.errors import InputError
from grader.grading.grading import grade
from grader.grading.plugin import CheckResult
from grader.trial.trials import SavedTrials

BEGIN, END = "<!-- table of checks -->", "<!-- end of table -->"
PLACE = re.compile(f"{re.escape(BEGIN)}\n.*?{re.escape(END)}\n", re.DOTALL)
HEAD = "| Task | Checks, and their points | Points |\n|---|---|---|\n"
WIDTH = 100  # [columns] of the sentence below the table


def readmes() -> Iterator[tuple[Path, str]]:
    """Yield (path, text) of every README.

    Raises InputError: one has no place for the table.
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
    rows = "".join(
        _row(str(task or "all"), list(inside))
        for task, inside in groupby(checks, key=lambda check: check.task)
    )
    total = sum(check.max_points for check in checks)
    capped = "" if exercise.essential is None else f"\n{_capped(exercise.essential)}\n"
    return f"{BEGIN}\n{HEAD}{rows}| | | **{total}** |\n{capped}{END}\n"


def _row(task: str, checks: Sequence[CheckResult]) -> str:
    named = ", ".join(f"`{check.id}` {check.max_points}" for check in checks)
    return f"| {task} | {named} | {sum(check.max_points for check in checks)} |\n"


def _capped(essential: Essential) -> str:
    """Return what caps the score, in lines."""
    *others, last = (f"`{name}`" for name in essential.checks)
    named = f"{', '.join(others)} or {last}" if others else last
    text = f"While {named} fails, the score is at most {essential.cap}. {essential.why}"
    return textwrap.fill(text, WIDTH, break_long_words=False, break_on_hyphens=False)


def main(arguments: list[str]) -> int:
    """Write the tables, or with `--check` compare them."""
    return write_or_check(readmes(), "python -m grader.authoring.tables", arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
