"""Known solutions graded along with the class: they tell whether the grader still judges right.

A right solution must pass and a wrong one must fail exactly what it names. When one comes out
otherwise, what was graded since the last good round can't be trusted, and is graded again.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from grader.authoring.proof import Claim, claims
from grader.classroom.store import Key
from grader.classroom.work import Unit
from grader.course.exercises import Exercise

REFERENCE, MUTANT = ".reference", ".mutant"  # no student's id begins with a dot
STRIKES = 2  # bad rounds in a row, after which an exercise is left to a person


@dataclass(frozen=True)
class Canary:
    """A known solution and what must come of it."""

    unit: Unit
    fails: frozenset[str]  # checks; nothing for a right solution

    def drift(self, grading: dict[str, Any] | None, problem: str) -> str:
        """Say how the outcome differs from what it must be; "" if it doesn't."""
        if grading is None:
            return problem
        by_outcome: dict[str, set[str]] = {}
        for check in grading["checks"]:
            by_outcome.setdefault(check["outcome"], set()).add(check["id"])
        unsure = by_outcome.get("error", set()) | by_outcome.get("inconclusive", set())
        if unsure:
            return f"could not judge {', '.join(sorted(unsure))}"
        expected = self.fails - by_outcome.get("unavailable", set())
        wrong = by_outcome.get("fail", set()) ^ expected
        if wrong:
            return f"came out otherwise in {', '.join(sorted(wrong))}"
        return ""


@dataclass
class CanaryRounds:
    """The canaries of one exercise during a run."""

    canaries: list[Canary]
    every: int  # units between two rounds
    trusted: bool = False  # the last round was good
    since: int = 0  # units graded after it
    strikes: int = 0
    asked: bool = False  # for a round, because a unit could not be judged
    waiting: list[Canary] = field(default_factory=list)  # of the present round
    out: dict[Key, Canary] = field(default_factory=dict)
    covers: list[Key] = field(default_factory=list)  # units that a good round would confirm
    drifts: list[str] = field(default_factory=list)

    @property
    def in_round(self) -> bool:
        """A round has begun and is not over."""
        return bool(self.waiting or self.out)

    @property
    def due(self) -> bool:
        """A round should begin before another unit does."""
        return not self.trusted or self.asked or self.since >= self.every

    def begin(self, covers: list[Key]) -> None:
        """Begin a round that vouches for these units."""
        self.waiting, self.covers, self.drifts = list(self.canaries), covers, []
        self.since, self.asked = 0, False

    def next(self) -> Unit:
        """Return the next canary of the round."""
        canary = self.waiting.pop(0)
        self.out[canary.unit.key] = canary
        return canary.unit


def canaries_of(exercise: Exercise, sample: Unit) -> list[Canary]:
    """Return the reference and a mutant of an exercise, graded as `sample` is.

    None if the solutions are not there.
    """
    if not (exercise.solutions / exercise.files[0]).is_file():
        return []
    found = []
    known = list(claims(exercise))
    right = next(claim for claim in known if claim.kind == "reference")
    wrong = next((claim for claim in known if _is_plain_mutant(claim)), None)
    for name, claim in ((REFERENCE, right), (MUTANT, wrong)):
        if claim is None:
            continue
        texts = {file: text.encode() for file, text in claim.files.items()}
        unit = Unit(
            name, exercise.slug, texts, field=sample.field,
            tier=sample.tier, bags=False, trust=sample.trust, canary=True,
        )  # fmt: skip
        found.append(Canary(unit, claim.fails))
    return found


def _is_plain_mutant(claim: Claim) -> bool:
    """One that fails core checks and needs no library of its own."""
    core = not any(check.startswith("field_") for check in claim.fails)
    return claim.kind == "mutant" and core and not claim.requires
