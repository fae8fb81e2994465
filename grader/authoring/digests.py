"""Digests and verdicts of solutions: what another engine, or another runtime, must leave as it was.

`python -m grader.authoring.digests FILE` writes them; with `--compare` it says which are others.
`--portable` grades on the portable runtime, `--all` takes mutants and skeletons, too.

A digest re-encodes every message. Two things are left out of it: the order of messages of different
topics at one moment, which means nothing, and how long a training took. What a trained model says
is compared to a nanometre per second: a forest that predicts in several threads adds its trees up
in the order in which they end.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
from msgspec import structs

from grader.claims.claims import Claim, claims, grade_claim
from grader.course.exercises import all_exercises, find_exercise
from grader.errors import GraderError
from grader.launchers import fork_server
from grader.recording import Recording
from grader.recording.training import ModelAnswers
from rclpy_virtual_time import RosEnvironment

Digests = dict[str, dict[str, str]]  # claim → scenario → digest; and its verdict
VERDICT = "verdict"  # in the place of a scenario's name
RIGHT = ("reference", "variant")
# Two runs of these mutants differ anyhow: an int in a byte field, and a float of numpy's in one of
# Python's, are memory that belongs to nobody.
UNSETTLED = ("level_as_int", "numpy_float_in_the_field")


def main(arguments: list[str]) -> int:
    """Write the digests, or compare with those of a file; 1 if there are others."""
    parser = argparse.ArgumentParser(prog="digests", description="Digests of solutions.")
    parser.add_argument("file", type=Path)
    parser.add_argument("exercises", nargs="*", metavar="EXERCISE")
    parser.add_argument("--compare", action="store_true")
    parser.add_argument("--all", action="store_true", help="mutants and skeletons, too")
    parser.add_argument("--portable", action="store_true", help="on the portable runtime")
    options = parser.parse_args(arguments)
    found: Digests = {}
    for exercise in [find_exercise(name) for name in options.exercises] or all_exercises():
        for claim in claims(exercise):
            wanted = claim.stem not in UNSETTLED if options.all else claim.kind in RIGHT
            if wanted and not claim.lacks:
                print(claim.name, file=sys.stderr, flush=True)
                found[claim.name] = _digests(claim, portable=options.portable)
    if not options.compare:
        options.file.parent.mkdir(parents=True, exist_ok=True)
        options.file.write_bytes(msgspec.json.format(msgspec.json.encode(found)))
        return 0
    others = differences(msgspec.json.decode(options.file.read_bytes(), type=Digests), found)
    print("".join(f"{line}\n" for line in others) + f"{len(others)} differ")
    return 1 if others else 0


def _digests(claim: Claim, *, portable: bool) -> dict[str, str]:
    ros = RosEnvironment.portable() if portable else RosEnvironment.find()
    with fork_server(ros, libraries=claim.exercise.libraries) as server:
        try:
            grading = grade_claim(claim, server)
        except GraderError as error:
            return {VERDICT: str(error)}
    said = ", ".join(f"{check.id} {check.outcome}" for check in grading.checks)
    found = {recording.name: comparable(recording).digest() for recording in grading.recordings}
    return {**found, VERDICT: f"{grading.score} points: {said}"}


def differences(before: Digests, after: Digests) -> list[str]:
    """Return what differs between claims that both have, as `claim: scenario`."""
    return [
        f"{claim}: {place}"
        for claim in sorted(before.keys() & after.keys())
        for place in sorted(before[claim].keys() | after[claim].keys())
        if before[claim].get(place) != after[claim].get(place)
    ]


def comparable(recording: Recording) -> Recording:
    """Return a recording without what may differ between two runs."""
    published = tuple(sorted(recording.published, key=lambda m: (m.time, m.topic)))
    outcome, training = recording.outcome, recording.training
    if training is not None or recording.live is not None:
        outcome = replace(outcome, at=0.0)  # in wall-clock time
    if training is not None:
        names = ("pickle", "again", "onnx")
        rounded = {name: _rounded(getattr(training, name)) for name in names}
        training = structs.replace(training, **rounded)
    return replace(recording, published=published, outcome=outcome, training=training)


def _rounded(answers: ModelAnswers) -> ModelAnswers:
    return structs.replace(answers, values=np.round(answers.speeds, 9).tobytes())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
