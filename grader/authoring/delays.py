"""What delays the reference solutions survive: `course delay` shows it beside a student's number.

`python -m grader.authoring.delays` drives them all (minutes) and writes the table that the command
reads; with `--check`, and exercises, it compares instead.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.drive import drive_in
from grader.drive.delay import REFERENCE, WALLS, WORLDS, Survived, delays, reference_of
from grader.link.choice import start_launcher

HEAD = """\
# The largest delays [ms] that the reference solutions survive, up to 300; -1: none.
# Made by `python -m grader.authoring.delays`.
"""


def main(arguments: Sequence[str]) -> int:
    """Measure and write, or compare; return the exit code."""
    parser = argparse.ArgumentParser(prog="grader.authoring.delays", description=__doc__)
    parser.add_argument("exercise", nargs="*", help="only these, by name or number; for --check")
    parser.add_argument("--check", action="store_true", help="compare with the table")
    options = parser.parse_args(arguments)
    chosen = [find_exercise(name) for name in options.exercise] or driving()
    if options.exercise and not options.check:
        parser.error("the table is written as a whole; exercises go with --check")
    made = {exercise.slug: measured(exercise) for exercise in chosen}
    if not options.check:
        REFERENCE.write_text(text(made), "utf-8")
        return 0
    differing = [one.slug for one in chosen if reference_of(one) != made[one.slug]]
    for slug in differing:
        print(f"{REFERENCE.name} is out of step: {slug} now has {made[slug]}", file=sys.stderr)
    return 1 if differing else 0


def driving() -> list[Exercise]:
    """Return the exercises that have worlds for delays."""
    return [one for one in all_exercises() if one.number in {*WORLDS, *WALLS}]


def measured(exercise: Exercise) -> Survived:
    """Drive the reference of an exercise with every delay."""
    submission = find_submission(exercise.solutions / exercise.files[0])
    with start_launcher(exercise.libraries) as forkserver:
        drives = delays(exercise, lambda scenario: drive_in(submission, scenario, forkserver))
    return drives.survived


def text(table: dict[str, Survived]) -> str:
    """Return the table as TOML."""
    rows = (
        f"[{slug}]\nsensors = {row.sensors}\ncommands = {row.commands}\n"
        for slug, row in table.items()
    )
    return "\n".join([HEAD, *rows])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
