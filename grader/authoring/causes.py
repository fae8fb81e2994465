"""Collect the known mistakes for `grader.grading.causes.known`: how the mutants fail.

`python -m grader.authoring.causes [EXERCISE …]` grades every mutant, which takes as long as the
proof, and writes `grader/grading/causes/known/EXERCISE.toml`: for each fingerprint of failures the
mistakes that fail so. What ends a node's program needs no entry: it explains itself.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Sequence

from grader.authoring.gradings import gradings
from grader.authoring.proof import claims
from grader.course.exercises import all_exercises, find_exercise
from grader.errors import InputError
from grader.grading.causes.ends import WIRED
from grader.grading.causes.known import KNOWN, MOST, fingerprint
from grader.grading.plugin import FAIL, CheckResult

HEAD = "# Written by `python -m grader.authoring.causes {slug}`: the mistakes by how they fail.\n"


def main(arguments: list[str]) -> int:
    """Write the files of the exercises named; all by default."""
    parser = argparse.ArgumentParser(prog="causes", description="Collect known mistakes.")
    parser.add_argument("exercises", nargs="*", metavar="EXERCISE", help="name or number; or all")
    cpus = len(os.sched_getaffinity(0))
    parser.add_argument("--workers", type=int, default=cpus, help=f"processes; {cpus} by default")
    options = parser.parse_args(arguments)
    try:
        exercises = [find_exercise(name) for name in options.exercises] or all_exercises()
    except InputError as error:
        parser.error(str(error))
    for exercise in exercises:
        mutants = [c for c in claims(exercise) if c.kind == "mutant" and not c.lacks]
        found = gradings(mutants, options.workers)
        rows = [(claim.about, graded.checks) for claim, graded in zip(mutants, found, strict=True)]
        text = known_toml(exercise.slug, rows)
        (KNOWN / f"{exercise.slug}.toml").write_text(text, "utf-8")
        print(f"{exercise.slug}: {text.count(' = [')} fingerprints of {len(mutants)} mutants")
    return 0


def known_toml(slug: str, rows: Iterable[tuple[str, Sequence[CheckResult]]]) -> str:
    """Return the file of an exercise, from the mistakes and their checks."""
    causes: dict[str, list[str]] = {}
    for mistake, checks in rows:
        failed = [check for check in checks if check.outcome == FAIL]
        if failed and WIRED not in failed[0].id:
            causes.setdefault(fingerprint(failed), []).append(mistake)
    lines = [HEAD.format(slug=slug), "[causes]"]
    for key, mistakes in sorted(causes.items()):
        if len(mistakes) > MOST:  # it could be any of them
            continue
        lines += [f'"{key}" = [', *(f"  {_quoted(text)}," for text in sorted(mistakes)), "]"]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
