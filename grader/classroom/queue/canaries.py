"""Known solutions graded along with the class: they show whether the grader still judges right.

A right solution must pass, and a wrong one must fail the checks it names. They are graded
before an exercise's class, every so often, and after it. An unexpected round may have been caused
by other work on the machine, so it is repeated alone. After a good repetition, the files graded
after the last good round are graded again; after a bad one, they and the rest of the exercise are
left to a person. A stall of the machine is no verdict: such a round confirms nothing.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from grader.claims.claims import claims
from grader.classroom.options import Options
from grader.classroom.queue.store import Key, Store
from grader.classroom.queue.work import Unit, UnitResult, stalled
from grader.course.exercises import Exercise

REFERENCE, MUTANT = ".reference", ".mutant"  # no student's id begins with a dot


@dataclass(frozen=True)
class Canary:
    """A known solution and the outcome it must have."""

    unit: Unit
    fails: frozenset[str]  # checks; none for a right solution

    def drift(self, result: UnitResult) -> str:
        """Say how the outcome differs from the one it must have; "" if it doesn't."""
        if result.grading is None:
            return f"could not be graded: {result.problem}"
        by_outcome: dict[str, set[str]] = {}
        for check in result.grading["checks"]:
            by_outcome.setdefault(check["outcome"], set()).add(check["id"])
        unsure = by_outcome.get("error", set()) | by_outcome.get("inconclusive", set())
        if unsure:
            return f"could not judge {', '.join(sorted(unsure))}"
        expected = self.fails - by_outcome.get("unavailable", set())
        failed = by_outcome.get("fail", set())
        wrong = expected - failed if self.fails else failed
        return f"had an unexpected outcome in {', '.join(sorted(wrong))}" if wrong else ""


@dataclass(frozen=True)
class Verdict:
    again: Sequence[Key] = ()  # units to grade again
    held: Sequence[Key] = ()  # units to leave to a person
    why: str = ""  # they are
    note: str = ""


@dataclass
class _Rounds:
    """The canaries of one exercise during a run."""

    canaries: list[Canary]
    trusted: bool = False  # the last round was good
    graded: int = 0  # units since the last round
    doubted: bool = False  # a unit could not be judged: the grader may be at fault
    unconfirmed: bool = False  # the machine stalled in the last round, with nothing beside it
    given_up: str = ""  # why, if a person has to look
    alone: bool = False  # this round repeats a bad one, with nothing beside it
    suspect: str = ""  # how that was wrong, if it did not only stall
    waiting: list[Canary] = field(default_factory=list)  # in this round
    running: dict[Key, Canary] = field(default_factory=dict)  # in this round
    confirms: list[Key] = field(default_factory=list)  # units that a good round confirms
    drifts: list[str] = field(default_factory=list)  # in this round
    stalls: bool = False  # in this round

    def begin(self, confirms: list[Key], *, alone: bool = False) -> None:
        """Begin a round; if it is good, it confirms these units."""
        self.waiting = [replace(c, unit=replace(c.unit, alone=alone)) for c in self.canaries]
        self.confirms, self.drifts, self.stalls, self.alone = confirms, [], False, alone
        self.graded, self.doubted, self.unconfirmed = 0, False, False

    def next(self) -> Unit:
        canary = self.waiting.pop(0)
        self.running[canary.unit.key] = canary
        return canary.unit


class Canaries:
    """The canaries of all exercises during a run."""

    def __init__(self, store: Store, exercises: Mapping[str, Exercise], options: Options) -> None:
        self._store = store
        self._every = options.canaries  # units between two rounds
        self._rounds: dict[str, _Rounds] = {}
        for slug, exercise in exercises.items() if options.canaries else ():
            sample = Unit("", slug, {}, field=options.field, trust=options.trust)
            found = canaries_of(exercise, sample)
            if not found:
                store.note(f"{slug}: without its solutions, no canaries were graded.")
            self._rounds[slug] = _Rounds(found, trusted=not found)

    @property
    def wants_quiet(self) -> bool:
        """The next canary has to wait until nothing else runs."""
        return any(rounds.alone and rounds.waiting for rounds in self._rounds.values())

    def allows(self, slug: str) -> bool:
        """Return whether submissions to an exercise may be graded now."""
        return slug not in self._rounds or self._rounds[slug].trusted

    def notes(self) -> list[str]:
        """Say which gradings no good canary has confirmed."""
        counts = {slug: len(self._store.unverified(slug)) for slug in self._rounds}
        return [
            f"{slug}: no known solution confirms {count} gradings, because the machine stalled "
            "while it was graded, even with nothing else running. They count; the next run tries "
            "again."
            for slug, count in counts.items()
            if count and self._rounds[slug].unconfirmed
        ]

    def next(self, waiting: Collection[Key], running: Collection[Key]) -> Unit | None:
        """Return the canary to run next, if there is one to run now."""
        for slug, rounds in self._rounds.items():
            if rounds.waiting:
                return rounds.next()
            if rounds.running or not rounds.canaries:
                continue
            queued = any(key[1] == slug for key in waiting)
            busy = any(key[1] == slug for key in running)
            due = not rounds.trusted or rounds.doubted or rounds.graded >= self._every
            unverified = [] if rounds.unconfirmed else self._store.unverified(slug)
            if (queued and due) or (unverified and not queued and not busy):
                rounds.begin(self._store.unverified(slug))
                return rounds.next()
        return None

    def graded(self, key: Key) -> str:
        """Count a submission; say why it has to be held, if the grader has failed meanwhile."""
        rounds = self._rounds.get(key[1])
        if rounds is None:
            return ""
        rounds.graded += 1
        rounds.unconfirmed = False
        return rounds.given_up

    def doubt(self, slug: str) -> None:
        """A submission could not be judged: the next canaries tell whether it is the grader."""
        if slug in self._rounds:
            self._rounds[slug].doubted = True

    def done(self, unit: Unit, result: UnitResult, waiting: Collection[Key]) -> Verdict:
        rounds = self._rounds[unit.exercise]
        drift = rounds.running.pop(unit.key).drift(result)
        if stalled(result.grading):
            rounds.stalls = True
        else:
            self._store.canary(unit.key, result.grading, drift)
            if drift:
                rounds.drifts.append(f"the known solution {unit.student.lstrip('.')} {drift}")
        if rounds.waiting or rounds.running:
            return Verdict()
        return self._verdict(unit.exercise, rounds, waiting)

    def _verdict(self, slug: str, rounds: _Rounds, waiting: Collection[Key]) -> Verdict:
        why = "; ".join(rounds.drifts)
        if (why or rounds.stalls) and not rounds.alone:
            rounds.trusted, rounds.suspect = False, why
            rounds.begin(self._store.unverified(slug), alone=True)
            return Verdict()
        if why:
            rounds.canaries = []
            rounds.given_up = f"the grader could not be trusted: {why}"
            held = [*self._store.unverified(slug), *(key for key in waiting if key[1] == slug)]
            note = f"{slug}: {why}, twice in a row; held for a person."
            return Verdict(held=held, why=rounds.given_up, note=note)
        suspect = rounds.confirms if rounds.suspect else []
        again = [key for key in suspect if not self._store.counts(key).quarantines]
        note = (
            f"{slug}: {rounds.suspect}, but not with nothing beside it. The {len(again)} "
            "submissions graded since the last good canary were quarantined and graded again."
        )
        rounds.trusted, rounds.suspect, rounds.alone = True, "", False
        rounds.unconfirmed = rounds.stalls
        if rounds.stalls:
            return Verdict()  # it confirms nothing, which `notes` says
        self._store.verify(key for key in rounds.confirms if key not in again)
        return Verdict(again, note=note if again else "")


def canaries_of(exercise: Exercise, sample: Unit) -> list[Canary]:
    """Return the reference and a mutant of an exercise, to be graded like `sample`.

    Without the exercise's solutions there are none.
    """
    if not (exercise.solutions / exercise.files[0]).is_file():
        return []
    known = list(claims(exercise))
    right = next(claim for claim in known if claim.kind == "reference")
    mutants = (  # in one file, that fail core checks, without libraries
        claim for claim in known
        if claim.kind == "mutant" and not claim.requires
        and not any(check.startswith("field_") for check in claim.fails)
    )  # fmt: skip
    wrong = next(mutants, None)
    return [
        Canary(
            replace(
                sample,
                student=name,
                files={file: text.encode() for file, text in claim.files.items()},
                bags=False,
                canary=True,
            ),
            claim.fails,
        )
        for name, claim in ((REFERENCE, right), (MUTANT, wrong))
        if claim is not None
    ]
