"""Digests of all trials of right solutions: what a change of the engine must leave as it was.

`python -m grader.authoring.digests FILE` writes them; with `--compare` it says which are others.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import msgspec

from grader.authoring.claims import Claim, claims, grade_claim
from grader.course.exercises import all_exercises, find_exercise
from grader.link.hosts import ForkServer
from grader.trial.kept import KeptRecordings
from sim.messages import EPOCH_NS

Digests = dict[str, dict[str, str]]  # claim → scenario → digest


def main(arguments: list[str]) -> int:
    """Write the digests, or compare with those of a file; 1 if there are others."""
    parser = argparse.ArgumentParser(prog="digests", description="Digests of right solutions.")
    parser.add_argument("file", type=Path)
    parser.add_argument("exercises", nargs="*", metavar="EXERCISE")
    parser.add_argument("--compare", action="store_true")
    parser.add_argument("--recordings", type=Path, metavar="FOLDER", help="kept by the proof")
    options = parser.parse_args(arguments)
    kept = KeptRecordings(options.recordings) if options.recordings else None
    found: Digests = {}
    for exercise in [find_exercise(name) for name in options.exercises] or all_exercises():
        for claim in claims(exercise):
            if claim.kind in ("reference", "variant") and not claim.lacks:
                print(claim.name, file=sys.stderr, flush=True)
                found[claim.name] = _digests(claim, kept)
    if not options.compare:
        options.file.write_bytes(msgspec.json.format(msgspec.json.encode(found)))
        return 0
    others = _others(msgspec.json.decode(options.file.read_bytes(), type=Digests), found)
    print("".join(f"{line}\n" for line in others) + f"{len(others)} of other digests")
    return 1 if others else 0


def _digests(claim: Claim, kept: KeptRecordings | None) -> dict[str, str]:
    with ForkServer(EPOCH_NS, libraries=claim.exercise.libraries) as server:
        recordings = grade_claim(claim, server, kept=kept).recordings
    return {recording.name: recording.digest() for recording in recordings}


def _others(before: Digests, after: Digests) -> list[str]:
    return [
        f"{claim}: {scenario}"
        for claim, scenarios in after.items()
        for scenario, digest in scenarios.items()
        if before.get(claim, {}).get(scenario, digest) != digest
    ]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
