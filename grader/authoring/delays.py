"""What delays the reference solutions survive: `course delay` shows it beside a student's number.

`python -m grader.authoring.delays [EXERCISE …]` drives them (minutes), and compares with what their
contracts say (`Contract.survives`).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from grader.checks.contract import Survived
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.drive import drive_in
from grader.drive.delay import delays
from grader.exercises import contract_of
from grader.link.choice import start_launcher


def main(arguments: Sequence[str]) -> int:
    """Measure and compare; return the exit code."""
    parser = argparse.ArgumentParser(prog="grader.authoring.delays", description=__doc__)
    parser.add_argument("exercise", nargs="*", help="only these, by name or number")
    options = parser.parse_args(arguments)
    chosen = [find_exercise(name) for name in options.exercise] or driving()
    others = 0
    for exercise in chosen:
        made, said = measured(exercise), contract_of(exercise).survives
        others += made != said
        but = "" if made == said else f"; its contract.py says {said}"
        print(f"{exercise.slug}: survives={made}{but}")
    return 1 if others else 0


def driving() -> list[Exercise]:
    """Return the exercises whose nodes drive by themselves."""
    return [each for each in all_exercises() if contract_of(each).drives]


def measured(exercise: Exercise) -> Survived:
    """Drive the reference of an exercise with every delay."""
    submission = find_submission(exercise.solutions / exercise.files[0])
    with start_launcher(exercise.libraries) as forkserver:
        drives = delays(exercise, lambda scenario: drive_in(submission, scenario, forkserver))
    return drives.survived


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
