"""Collect the known mistakes for `grader.grading.causes.known`: how the mutants fail.

`python -m grader.authoring.causes [EXERCISE …]` grades every mutant in one process, which takes
twice as long as the proof, and writes `grader/grading/causes/known/EXERCISE.toml`: for each
fingerprint of failures the mistakes that fail so. What ends a node's program needs no entry: it
explains itself.

With `--check` it grades nothing: it says which mistakes in the files are no mutant's any more.
Whether each mutant is still told its own mistake, the proof sees as it goes along.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator

from grader.authoring.mutants import mutants
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.errors import InputError
from grader.grading.causes.ends import WIRED
from grader.grading.causes.known import KNOWN, MOST, catalogue, fingerprint, told_as
from grader.grading.plugin import FAIL
from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS

HEAD = "# Written by `python -m grader.authoring.causes {slug}`: the mistakes by how they fail.\n"


def main(arguments: list[str]) -> int:
    """Write, or check, the files of the exercises named; all by default."""
    parser = argparse.ArgumentParser(prog="causes", description="Collect known mistakes.")
    parser.add_argument(
        "exercises", nargs="*", metavar="EXERCISE", help="name or number; all by default"
    )
    parser.add_argument("--check", action="store_true", help="only look for stale mistakes")
    options = parser.parse_args(arguments)
    try:
        exercises = [find_exercise(name) for name in options.exercises] or all_exercises()
    except InputError as error:
        parser.error(str(error))
    if options.check:
        return int(sum(_is_stale(exercise) for exercise in exercises) > 0)  # all are told
    for exercise in exercises:
        text = known_toml(exercise.slug, _failures(exercise))
        (KNOWN / f"{exercise.slug}.toml").write_text(text, "utf-8")
        print(f"{exercise.slug}: {text.count(' = [')} fingerprints")
    return 0


def _is_stale(exercise: Exercise) -> bool:
    """Print the mistakes in an exercise's file that are none of its mutants'."""
    left = stale(exercise)
    for mistake in left:
        print(f"{exercise.slug}: no mutant's mistake: {mistake}")
    if left:
        print(f"run `python -m grader.authoring.causes {exercise.slug}`")
    return bool(left)


def stale(exercise: Exercise) -> list[str]:
    """Return the mistakes in an exercise's file that are none of its mutants' any more."""
    theirs = {mutant.mistake for mutant in mutants(exercise)}
    told = {mistake for mistakes in catalogue(exercise.slug).values() for mistake in mistakes}
    return sorted(told - theirs)


def misled(exercise: Exercise, mistake: str, cause: str) -> list[str]:
    """Return the known mistakes of others that a cause names in place of a mutant's own."""
    if told_as(mistake) in cause:
        return []
    known = {text for texts in catalogue(exercise.slug).values() for text in texts}
    return sorted(text for text in known if told_as(text) in cause)


def _failures(exercise: Exercise) -> Iterator[tuple[str, str]]:
    """Yield the mistakes of an exercise, each with the fingerprint of its failures."""
    from grader.authoring.proof import claims, grade_claim  # noqa: PLC0415  (it imports this)

    with ForkServer(EPOCH_NS, libraries=exercise.libraries) as forkserver:
        for claim in claims(exercise):
            if claim.kind != "mutant" or claim.lacks:
                continue
            grading = grade_claim(claim, forkserver)
            failed = [check for check in grading.checks if check.outcome == FAIL]
            if failed and WIRED not in failed[0].id:
                trials = {recording.name: recording for recording in grading.recordings}
                yield claim.about, fingerprint(failed, trials)


def known_toml(slug: str, rows: Iterable[tuple[str, str]]) -> str:
    """Return the file of an exercise, from mistakes and fingerprints."""
    causes: dict[str, list[str]] = {}
    for mistake, key in rows:
        causes.setdefault(key, []).append(mistake)
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
