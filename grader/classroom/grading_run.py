"""One run over the queue: grade what waits, and watch the grader with known solutions."""

from __future__ import annotations

import io
import shutil
import tarfile
import tempfile
from collections.abc import Mapping
from pathlib import Path

from grader.classroom import engine
from grader.classroom.canaries import MAX_STRIKES, Canary, CanaryRounds, canaries_of
from grader.classroom.candidates import Candidate
from grader.classroom.engine import WorkerDied
from grader.classroom.options import Options
from grader.classroom.progress import Progress
from grader.classroom.store import Key, Store
from grader.classroom.work import Unit, UnitResult, stalled, unjudged
from grader.course.exercises import Exercise
from grader.errors import DiskFull, InputError, is_disk_full
from grader.link.scratch import has_space

MAX_DEATHS = 3  # of a unit's workers; then it is left to a person
MAX_UNSURE = 2  # gradings that could not judge
MAX_QUARANTINES = 2
RECORDINGS = "recordings"
PARTS = ".part"  # below RECORDINGS: bags that are being written


class GradingRun:
    """One run over the queue of a class."""

    def __init__(
        self,
        store: Store,
        out: Path,
        candidates: Mapping[Key, Candidate],
        options: Options,
        progress: Progress,
    ) -> None:
        self._store = store
        self._out = out
        self._candidates = candidates
        self._options = options
        self._progress = progress
        self._running: set[Key] = set()
        self._bag_folders = 0  # made so far
        self._exercises = {key[1]: each.exercise for key, each in candidates.items()}
        self._rounds: dict[str, CanaryRounds] = {}  # by exercise

    def run(self) -> None:
        """Grade what waits.

        Raises
        ------
        InputError
            Code would run without isolation.
        """
        waiting = self._waiting()
        self._progress.begin(len(waiting))
        unverified = any(self._store.unverified(slug) for slug in self._exercises)
        if not waiting and not (self._options.canaries and unverified):
            return
        if self._options.canaries:
            self._rounds = {
                slug: self._canary_rounds(exercise) for slug, exercise in self._exercises.items()
            }
        with engine.open_workers(self._options.workers, self._options.dask) as workers:
            if not self._options.trust and (problem := engine.refusal(workers)):
                raise InputError(problem)
            engine.run(workers, self._next, self._done)

    def _canary_rounds(self, exercise: Exercise) -> CanaryRounds:
        sample = Unit(
            "", exercise.slug, {}, field=self._options.field, tier=self._options.tier,
            trust=self._options.trust,
        )  # fmt: skip
        canaries = canaries_of(exercise, sample)
        if not canaries:
            self._store.note(f"{exercise.slug}: without its solutions, no canaries were graded.")
        return CanaryRounds(canaries, self._options.canaries, trusted=not canaries)

    def _waiting(self) -> list[Key]:
        known = (key for key in self._store.waiting() if key in self._candidates)
        return [key for key in known if key not in self._running]

    def _next(self, busy: bool) -> Unit | None:
        """Return what to run next, canaries first; None if nothing may start now."""
        if busy and any(rounds.alone for rounds in self._rounds.values()):
            return None
        waiting = self._waiting()
        return self._next_canary(waiting) or self._next_submission(waiting, busy)

    def _next_canary(self, waiting: list[Key]) -> Unit | None:
        for slug, rounds in self._rounds.items():
            if rounds.waiting:
                return rounds.next()
            if rounds.in_round or not rounds.canaries:
                continue
            queued = any(key[1] == slug for key in waiting)
            running = any(key[1] == slug for key in self._running)
            unverified = [] if rounds.unconfirmed else self._store.unverified(slug)
            if (queued and rounds.due) or (unverified and not queued and not running):
                rounds.begin(self._store.unverified(slug))
                return rounds.next()
        return None

    def _next_submission(self, waiting: list[Key], busy: bool) -> Unit | None:
        for key in waiting:
            rounds = self._rounds.get(key[1])
            if rounds is not None and not rounds.trusted:
                continue
            counts = self._store.counts(key)
            alone = counts.deaths >= MAX_DEATHS - 1 or counts.unsure > 0
            if alone and busy:
                return None
            unit = self._unit(key, alone=alone)
            if unit is not None:
                return unit
        return None

    def _unit(self, key: Key, *, alone: bool = False) -> Unit | None:
        candidate = self._candidates[key]
        try:
            files = candidate.read()
        except OSError as error:
            self._hold(key, f"a file that can't be read any more ({error.strerror})")
            return None
        bag_folder = ""
        if self._options.bags and not self._options.dask:
            bag_folder = str(self._new_bag_folder().resolve())
        self._running.add(key)
        self._store.claim(key, candidate.input_hash(files, self._options), files)
        return Unit(
            *key, files, seed=candidate.seed, field=self._options.field, tier=self._options.tier,
            bags=self._options.bags, bag_folder=bag_folder, trust=self._options.trust, alone=alone,
        )  # fmt: skip

    def _done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        if unit.canary:
            self._canary_done(unit, result)
            return
        self._running.discard(unit.key)
        try:
            self._submission_done(unit, result)
        except Exception as error:  # of one result; the others are not held up
            if is_disk_full(error):
                raise
            self._hold(
                unit.key, f"the result could not be stored ({type(error).__name__}: {error})"
            )

    def _submission_done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        if isinstance(result, WorkerDied):
            self._died(unit, result)
            return
        if result.disk_full:
            self._stop_if_disk_full(unit)
        problem = result.problem if result.grading is None else unjudged(result.grading)
        rounds = self._rounds.get(unit.exercise)
        if problem:
            if rounds is not None and not stalled(result.grading):
                rounds.requested = True  # was it the submission, or the grader?
            if self._store.requeue(unit.key, unsure=True).unsure < MAX_UNSURE:
                self._tell(unit, f"will retry, alone, at the end: {problem}", over=False)
                return
        self._finish(unit, result, problem)
        if rounds is not None:
            rounds.graded += 1
            rounds.unconfirmed = False
            if rounds.strikes >= MAX_STRIKES:  # it ran on the grader that failed
                self._store.hold(unit.key, "the grader could not be trusted while it ran")

    def _stop_if_disk_full(self, unit: Unit) -> None:
        """Stop if there is still no space; else the unit itself may have taken it.

        Raises
        ------
        DiskFull
            The disk is full with the unit over: the next one would end as it did.
        """
        if not self._options.dask and not has_space(self._out, Path(tempfile.gettempdir())):
            self._store.requeue(unit.key)
            raise DiskFull("no space is left")

    def _finish(self, unit: Unit, result: UnitResult, problem: str) -> None:
        self._store.finish(
            unit.key,
            result.grading,
            problem=problem,
            recordings=self._store_bags(unit, result),
            cpu_s=result.cpu_s,
            wall_s=result.wall_s,
            worker=result.worker,
        )
        if problem:
            self._tell(unit, f"held: {problem}")
        elif result.grading is not None:
            self._tell(unit, f"{result.grading['score']}/{result.grading['max_score']}")

    def _died(self, unit: Unit, why: WorkerDied) -> None:
        counts = self._store.requeue(unit.key, death=True)
        if counts.deaths < MAX_DEATHS:
            self._tell(unit, f"will retry: {why}", over=False)
            return
        self._hold(unit.key, f"{why}, {counts.deaths} times, at last with no other unit running")

    def _hold(self, key: Key, problem: str) -> None:
        self._store.hold(key, problem)
        self._progress.done(*key, f"held: {problem}")

    def _store_bags(self, unit: Unit, result: UnitResult) -> str | None:
        """Move the recordings to their place, which comes before the result is stored."""
        if not self._options.bags or result.grading is None:
            return None
        place = self._out / RECORDINGS / unit.student / unit.exercise
        part = Path(unit.bag_folder) if unit.bag_folder else self._unpacked(result.bags)
        shutil.rmtree(place, ignore_errors=True)
        place.parent.mkdir(parents=True, exist_ok=True)
        part.rename(place)
        return str(place.relative_to(self._out))

    def _unpacked(self, bags: bytes) -> Path:
        folder = self._new_bag_folder()
        with tarfile.open(fileobj=io.BytesIO(bags)) as archive:
            archive.extractall(folder, filter="data")
        return folder

    def _new_bag_folder(self) -> Path:
        self._bag_folders += 1
        folder = self._out / RECORDINGS / PARTS / str(self._bag_folders)
        folder.mkdir(parents=True)
        return folder

    def _canary_done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        rounds = self._rounds[unit.exercise]
        canary = rounds.running.pop(unit.key)
        if isinstance(result, WorkerDied):
            result = UnitResult(None, f"could not be graded: {result}")
        if stalled(result.grading):
            self._canary_stalled(canary, rounds)
            return
        drift = canary.drift(result.grading, result.problem)
        self._store.canary(unit.key, result.grading, drift, result.cpu_s)
        if drift:
            rounds.drifts.append(f"the known solution {unit.student.lstrip('.')} {drift}")
        if not rounds.in_round:
            self._end_round(unit.exercise, rounds)

    def _canary_stalled(self, canary: Canary, rounds: CanaryRounds) -> None:
        """Judge a canary again, alone; a machine that stalls even so is no reason for distrust."""
        name, slug = canary.unit.student.lstrip("."), canary.unit.exercise
        if not canary.unit.alone:
            rounds.again(canary)
            return
        rounds.unconfirmed = True
        self._remark(
            f"{slug}: the machine stalled twice while the known solution {name} was graded, at "
            "last with nothing else running. So it does not confirm what was graded; the next run "
            "tries again."
        )
        if not rounds.in_round:
            self._end_round(slug, rounds)

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
            hopeless += [key for key in self._waiting() if key[1] == slug]
            rounds.canaries, rounds.trusted = [], False
            self._remark(f"{slug}: {why}, {rounds.strikes} times in a row; held for a person.")
        for key in dict.fromkeys(hopeless):
            self._hold(key, f"the grader could not be trusted: {why}")

    def _remark(self, text: str) -> None:
        self._store.note(text)
        self._progress.say(text)

    def _tell(self, unit: Unit, outcome: str, *, over: bool = True) -> None:
        self._progress.done(unit.student, unit.exercise, outcome, over=over)
