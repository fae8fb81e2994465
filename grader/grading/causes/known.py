"""Known mistakes by how they fail: which checks, when, with which figures.

`known/EXERCISE.toml` is written by `python -m grader.authoring.causes` from the mutants. A mistake
is found by a fingerprint of its failures, so the file says nothing of what checks expect.
The figures are those of the scenarios' own seeds: with another seed nothing is found, and nothing
is said.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Annotated

import msgspec

from grader.checks.commands import answers
from grader.course.exercises import Exercise
from grader.grading.causes.cause import ByName, Cause, Failed
from grader.grading.causes.commands import never_moves
from sim.toml_input import convert, parse_toml, read_toml

KNOWN = Path(__file__).parent / "known"
MOST = 2  # causes that are told; if more fit, none is
_NUMBER = re.compile(r"\d+(?:\.\d+)?")


Text = Annotated[str, msgspec.Meta(min_length=1, max_length=300)]  # "Takes index 0 for …"


class _Catalogue(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    causes: dict[str, list[Text]]  # by fingerprint


def known_cause(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return the known mistake that fails exactly so; both if two do.

    A node that only ever stands fails alike for many reasons: that is no mistake's own pattern.
    """
    found = catalogue(exercise.slug).get(fingerprint(failed, trials), [])
    if not found or len(found) > MOST or (_drives(exercise) and never_moves(trials)):
        return None
    text = ", or ".join(told_as(text) for text in found)
    sure = len(found) == 1 and (len(failed) > 1 or _has_bench(failed[0], trials))
    how = "most probably" if sure else "perhaps" if len(found) == 1 else "one of two, perhaps"
    return Cause.of(exercise, f"{how}: {text}.", failed, all_of_it=len(failed) > 1)


def _drives(exercise: Exercise) -> bool:
    return any(topic.name == "/cmd_vel" for topic in exercise.topics)


def told_as(text: str) -> str:
    """Return a mistake as a cause tells it."""
    return f"the node {text[:1].lower()}{text[1:].rstrip('.')}"


def fingerprint(failed: Sequence[Failed], trials: ByName) -> str:
    """Return what is the same for all programs with the same mistake.

    When each check failed and with which figures; and all answers to the scans of its bench.
    """
    rows = sorted(
        (
            check.id,
            "" if check.time is None else f"{check.time:.2f}",
            *_NUMBER.findall(f"{check.message} {check.actual}"),
            *_trail(check, trials),
        )
        for check in failed
    )
    return hashlib.blake2b(repr(rows).encode(), digest_size=8).hexdigest()


def _has_bench(check: Failed, trials: ByName) -> bool:
    recording = trials.get(check.scenario or "")
    return recording is not None and bool(recording.scenario.bench_scans)


def _trail(check: Failed, trials: ByName) -> list[str]:
    """Return the speed after each scan of a bench."""
    if not _has_bench(check, trials):
        return []
    told = answers(trials[check.scenario or ""])
    return ["-" if answer.speed is None else f"{answer.speed:.2f}" for answer in told]


@cache
def catalogue(slug: str) -> dict[str, list[str]]:
    """Return the known mistakes of an exercise; none if nobody has collected them.

    Raises
    ------
    InputError
        The file is broken.
    """
    path = KNOWN / f"{slug}.toml"
    if not path.is_file():
        return {}
    return convert(parse_toml(read_toml(path), str(path)), _Catalogue, str(path)).causes
