"""The command for mutants: list, print or write those of an exercise, and count them.

`python -m grader.authoring.mutants EXERCISE` lists the mutants, `… EXERCISE NAME` prints one, and
with `--into FOLDER` writes it there with the exercise's other files: to read, to drive or to grade
(`--force`: in place of what is there). `--check` names each of all exercises that needs a `why`.
"""

import argparse
import signal
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from grader.claims.mutants import CATALOGUE, Mutant, find_mutant, mutants, submission_of
from grader.course.exercises import all_exercises, find_exercise
from grader.errors import InputError

ENOUGH = 3  # mutants of a check; what else it has says why


def main(arguments: list[str]) -> int:
    """List the mutants of an exercise, print one, write one's submission, or check how many."""
    parser = argparse.ArgumentParser(
        prog="grader.authoring.mutants", description="Wrong programs to read."
    )
    parser.add_argument("exercise", nargs="?", help="name or number")
    parser.add_argument("name", nargs="?", help="of a mutant; all are listed without")
    parser.add_argument("--into", type=Path, metavar="FOLDER", help="write all files there")
    parser.add_argument("--force", action="store_true", help="overwrite the files that are there")
    parser.add_argument("--check", action="store_true", help="only whether all are needed")
    options = parser.parse_args(arguments)
    if options.check == bool(options.exercise):
        parser.error("expected an exercise, or --check")
    if options.into and not options.name:
        parser.error("--into needs the name of a mutant")
    if options.check:
        return _check()
    try:
        exercise = find_exercise(options.exercise)
        if not options.name:
            for mutant in mutants(exercise):
                print(f"{mutant.name}: {mutant.mistake} [{', '.join(sorted(mutant.fails))}]")
            return 0
        mutant = find_mutant(exercise, options.name)
    except InputError as error:
        parser.error(str(error))
    if options.into is None:
        print(mutant.text, end="")
        return 0
    options.into.mkdir(parents=True, exist_ok=True)
    for file, text in submission_of(exercise, mutant).items():
        if (options.into / file).exists() and not options.force:
            parser.error(f"{options.into / file} is there already; --force overwrites it")
        (options.into / file).write_text(text, "utf-8")
        print(options.into / file)
    return 0


def _superfluous(found: Iterable[Mutant]) -> list[Mutant]:
    """Return the mutants without a `why` that are no check's first, second or third without one."""
    seen = Counter[str]()
    more = []
    for mutant in (each for each in found if not each.why):
        if all(seen[check] >= ENOUGH for check in mutant.fails):
            more.append(mutant)
        seen.update(mutant.fails)
    return more


def _check() -> int:
    """Print each mutant of any exercise that is one too many; 1 if there is one."""
    lines = [
        f"{exercise.solutions / CATALOGUE}: mutant.{mutant.name}: {ENOUGH} mutants before it name "
        f"{', '.join(sorted(mutant.fails))}: say `why` it is needed, too, or drop it"
        for exercise in all_exercises()
        for mutant in _superfluous(mutants(exercise))
    ]
    print("".join(f"{line}\n" for line in lines), end="")
    return 1 if lines else 0


if __name__ == "__main__":
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # … | head
    sys.exit(main(sys.argv[1:]))
