"""Known solutions graded along with the class: they show whether the grader still judges right.

A right solution must pass, and a wrong one must fail the checks it names. If one does not,
everything graded since the last good round is suspect and is graded again (`trust`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from grader.authoring.claims import Claim, claims
from grader.classroom.store import Key
from grader.classroom.work import Unit, unjudged
from grader.course.exercises import Exercise

REFERENCE, MUTANT = ".reference", ".mutant"  # no student's id begins with a dot
MAX_STRIKES = 2  # bad rounds in a row; then the exercise is left to a person


@dataclass(frozen=True)
class Canary:
    """A known solution and the outcome it must have."""

    unit: Unit
    fails: frozenset[str]  # checks; none for a right solution

    @property
    def name(self) -> str:
        """What the instructor reads."""
        return self.unit.student.lstrip(".")

    def unjudged(self, grading: dict[str, Any] | None) -> bool:
        """Tell whether the grader or the machine failed, so that there is no verdict."""
        return grading is None or bool(unjudged(grading))

    def drift(self, grading: dict[str, Any] | None, problem: str) -> str:
        """Say how the outcome differs from the one it must have; "" if it doesn't."""
        if grading is None:
            return problem
        by_outcome: dict[str, set[str]] = {}
        for check in grading["checks"]:
            by_outcome.setdefault(check["outcome"], set()).add(check["id"])
        unsure = by_outcome.get("error", set()) | by_outcome.get("inconclusive", set())
        if unsure:
            return f"could not judge {', '.join(sorted(unsure))}"
        expected = self.fails - by_outcome.get("unavailable", set())
        failed = by_outcome.get("fail", set())
        wrong = expected - failed if self.fails else failed
        if wrong:
            return f"had an unexpected outcome in {', '.join(sorted(wrong))}"
        return ""


@dataclass
class CanaryRounds:
    """The canaries of one exercise during a run."""

    canaries: list[Canary]
    every: int  # units between two rounds
    trusted: bool = False  # the last round was good
    graded: int = 0  # units since the last round
    strikes: int = 0  # bad rounds in a row
    unconfirmed: bool = False  # the machine stalled in the last round, even with nothing else on it
    requested: bool = False  # a unit could not be judged: the grader may be at fault
    waiting: list[Canary] = field(default_factory=list)  # in this round
    running: dict[Key, Canary] = field(default_factory=dict)  # in this round
    confirms: list[Key] = field(default_factory=list)  # units that a good round will confirm
    drifts: list[str] = field(default_factory=list)  # in this round

    @property
    def in_round(self) -> bool:
        """A round has begun and is not over."""
        return bool(self.waiting or self.running)

    @property
    def due(self) -> bool:
        """A round should begin before the next unit does."""
        return not self.trusted or self.requested or self.graded >= self.every

    def begin(self, confirms: list[Key]) -> None:
        """Begin a round; if it is good, it confirms these units."""
        self.waiting, self.confirms, self.drifts = [], confirms, []
        for canary in self.canaries:
            if self.strikes:  # was it what ran beside it?
                self.again(canary)
            else:
                self.waiting.append(canary)
        self.graded, self.requested, self.unconfirmed = 0, False, False

    @property
    def alone(self) -> bool:
        """The next canary has to wait until nothing else runs."""
        return bool(self.waiting) and self.waiting[0].unit.alone

    def again(self, canary: Canary) -> None:
        """Have a canary judged with nothing else running."""
        self.waiting.append(replace(canary, unit=replace(canary.unit, alone=True)))

    def next(self) -> Unit:
        """Return the next canary of the round."""
        canary = self.waiting.pop(0)
        self.running[canary.unit.key] = canary
        return canary.unit


def canaries_of(exercise: Exercise, sample: Unit) -> list[Canary]:
    """Return the reference and a mutant of an exercise, to be graded like `sample`.

    Without the exercise's solutions there are none.
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
    """Tell whether a claim is a mutant in one file that fails core checks and needs no library."""
    core = not any(check.startswith("field_") for check in claim.fails)
    return claim.kind == "mutant" and core and not claim.requires
