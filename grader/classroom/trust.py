"""Whether the grader can be trusted: what the known solutions come to, and what follows from it.

A canary with a wrong verdict is a strike against the grader. One that could not be judged may be
the machine's doing (a stall, a worker that was killed, a full disk, a neighbour's load), so it is
judged again with nothing beside it first. The same holds for the round after a strike: before an
exercise is left to a person, nothing else may have been to blame.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Protocol

from grader.classroom.canaries import MAX_STRIKES, CanaryRounds, canaries_of
from grader.classroom.engine import WorkerDied
from grader.classroom.options import Options
from grader.classroom.store import Key, Store
from grader.classroom.work import Unit, UnitResult, stalled
from grader.course.exercises import Exercise

MAX_QUARANTINES = 2


class Run(Protocol):
    """The run that the canaries watch over."""

    def waiting(self) -> list[Key]:
        """What is queued and does not run."""

    def hold(self, key: Key, problem: str) -> None:
        """Leave a unit to a person."""

    def expect(self, keys: Collection[Key]) -> None:
        """These units are graded in this run, too."""

    def say(self, text: str) -> None:
        """Tell the person at the terminal."""


class Trust:
    """The canaries of all exercises during a run."""

    def __init__(
        self, store: Store, run: Run, exercises: Mapping[str, Exercise], options: Options
    ) -> None:
        self._store = store
        self._run = run
        self._options = options
        self._rounds: dict[str, CanaryRounds] = {}
        if options.canaries:
            self._rounds = {slug: self._new(exercise) for slug, exercise in exercises.items()}

    def _new(self, exercise: Exercise) -> CanaryRounds:
        sample = Unit(
            "", exercise.slug, {}, field=bool(self._options.field), tier=self._options.tier,
            trust=self._options.trust,
        )  # fmt: skip
        canaries = canaries_of(exercise, sample)
        if not canaries:
            self._store.note(f"{exercise.slug}: without its solutions, no canaries were graded.")
        return CanaryRounds(canaries, self._options.canaries, trusted=not canaries)

    @property
    def wants_quiet(self) -> bool:
        """The next canary has to wait until nothing else runs."""
        return any(rounds.alone for rounds in self._rounds.values())

    def allows(self, slug: str) -> bool:
        """Tell whether submissions to an exercise may be graded now."""
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
            if rounds.in_round or not rounds.canaries:
                continue
            queued = any(key[1] == slug for key in waiting)
            busy = any(key[1] == slug for key in running)
            unverified = [] if rounds.unconfirmed else self._store.unverified(slug)
            if (queued and rounds.due) or (unverified and not queued and not busy):
                rounds.begin(self._store.unverified(slug))
                return rounds.next()
        return None

    def graded(self, key: Key) -> None:
        """Count a submission; one that ran on a grader that has failed is held."""
        rounds = self._rounds.get(key[1])
        if rounds is None:
            return
        rounds.graded += 1
        rounds.unconfirmed = False
        if rounds.strikes >= MAX_STRIKES:
            self._run.hold(key, "the grader could not be trusted while it ran")

    def doubt(self, slug: str) -> None:
        """A submission could not be judged: the next canaries tell whether it is the grader."""
        if slug in self._rounds:
            self._rounds[slug].requested = True

    def done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        """Take in the result of a canary."""
        rounds = self._rounds[unit.exercise]
        canary = rounds.running.pop(unit.key)
        if isinstance(result, WorkerDied):
            result = UnitResult(None, f"could not be graded: {result}")
        if canary.unjudged(result.grading) and not unit.alone:
            rounds.again(canary)
            return
        if stalled(result.grading):
            rounds.unconfirmed = True
            self._run.say(
                f"{unit.exercise}: the machine stalled while the known solution {canary.name} was "
                "graded, with nothing else running. It confirms nothing."
            )
        else:
            drift = canary.drift(result.grading, result.problem)
            self._store.canary(unit.key, result.grading, drift, result.cpu_s)
            if drift:
                rounds.drifts.append(f"the known solution {canary.name} {drift}")
        if not rounds.in_round:
            self._end_round(unit.exercise, rounds)

    def _end_round(self, slug: str, rounds: CanaryRounds) -> None:
        if not rounds.drifts:
            rounds.trusted, rounds.strikes = True, 0
            if not rounds.unconfirmed:
                self._store.verify(rounds.confirms)
            return
        rounds.trusted = False
        rounds.strikes += 1
        why = "; ".join(rounds.drifts)
        again = self._store.unverified(slug)
        if rounds.strikes < MAX_STRIKES:
            self._remark(
                f"{slug}: {why}. The {len(again)} submissions graded since the last good canary "
                "were quarantined and graded again."
            )
        hopeless = [
            key for key in again if self._store.counts(key).quarantines >= MAX_QUARANTINES - 1
        ]
        self._store.quarantine(key for key in again if key not in hopeless)
        if rounds.strikes >= MAX_STRIKES:
            hopeless += [key for key in self._run.waiting() if key[1] == slug]
            rounds.canaries, rounds.trusted = [], False
            self._remark(f"{slug}: {why}, {rounds.strikes} times in a row; held for a person.")
        self._run.expect(again)
        for key in dict.fromkeys(hopeless):
            self._run.hold(key, f"the grader could not be trusted: {why}")

    def _remark(self, text: str) -> None:
        self._store.note(text)
        self._run.say(text)
