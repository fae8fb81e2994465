"""One run over the queue: grade what waits, and watch the grader with known solutions."""

import io
import os
import shutil
import tarfile
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grader.classroom.options import Options
from grader.classroom.progress import Progress
from grader.classroom.queue import engine
from grader.classroom.queue.canaries import Canaries, Verdict
from grader.classroom.queue.candidate import Candidate
from grader.classroom.queue.store import Key, Store
from grader.classroom.queue.work import Unit, UnitResult, stalled, unjudged
from grader.classroom.row import GRADED, HELD, STALLS, TWICE, StoredResult
from grader.errors import DiskFull, InputError, is_disk_full

MAX_DEATHS = 3  # of a unit's workers; then it is left to a person
MAX_UNSURE = 2  # gradings that could not judge
MIN_SPACE = 16 * 1024 * 1024  # [bytes] that a grading needs; the recordings of one take 1 to 5 MiB
MIN_FILES = 200  # that a grading makes
RECORDINGS = "recordings"
PARTS = ".part"  # below RECORDINGS: bags that are being written


@dataclass
class GradingRun:
    """One run over the queue of a class."""

    store: Store
    out: Path
    candidates: Mapping[Key, Candidate]
    options: Options
    progress: Progress
    _running: set[Key] = field(default_factory=set)
    _bag_folders: int = 0  # made so far
    _canaries: Canaries = field(init=False)

    def run(self) -> list[str]:
        """Grade what waits; return what the report should say of this run.

        Raises InputError: code would run without isolation.
        """
        waiting = self._waiting()
        there = sum(not each.absent for each in self.candidates.values())
        self.progress.begin(len(waiting), there - len(waiting))
        exercises = {key[1]: each.exercise for key, each in self.candidates.items()}
        unverified = any(map(self.store.unverified, exercises))
        if not waiting and not (self.options.canaries and unverified):
            return []
        self._canaries = Canaries(self.store, exercises, self.options)
        with engine.open_workers(self.options.workers, self.options.dask) as workers:
            if not self.options.trust and (problem := engine.refusal(workers)):
                raise InputError(problem)
            engine.run(workers, self._next, self._done)
        return self._canaries.notes()

    def _waiting(self) -> list[Key]:
        known = (key for key in self.store.waiting() if key in self.candidates)
        return [key for key in known if key not in self._running]

    def _hold(self, key: Key, problem: str) -> None:
        self.store.hold(key, problem)
        self.progress.done(*key, f"held: {problem}")

    # --- what runs next --------------------------------------------------------------------------

    def _next(self, busy: bool) -> Unit | None:
        """Return what to run next, canaries first; None if nothing may start now."""
        if busy and self._canaries.wants_quiet:
            return None
        waiting = self._waiting()
        canary = self._canaries.next(waiting, self._running)
        return canary or self._next_submission(waiting, busy)

    def _next_submission(self, waiting: list[Key], busy: bool) -> Unit | None:
        for key in waiting:
            if not self._canaries.allows(key[1]):
                continue
            if self.candidates[key].leader and self._left_to_leader(key):
                continue
            counts = self.store.counts(key)
            alone = counts.deaths >= MAX_DEATHS - 1 or counts.unsure > 0
            if alone and busy:
                return None
            unit = self._unit(key, alone=alone)
            if unit is not None:
                return unit
        return None

    def _left_to_leader(self, key: Key) -> bool:
        """Return whether a member of a group gets, or has got, what its leader gets."""
        candidate, leader = self.candidates[key], (self.candidates[key].leader, key[1])
        files, _ = candidate.read()
        if self.store.share(leader, key, candidate.input_hash(files, self.options)):
            self.progress.done(*key, f"as {leader[0]}, with whom they handed in")
            return True
        return leader in self._running or leader in self.store.waiting()

    def _unit(self, key: Key, *, alone: bool = False) -> Unit | None:
        candidate = self.candidates[key]
        files, problem = candidate.read()
        if problem:
            self._hold(key, problem)
            return None
        bag_folder = ""
        if self.options.bags and not self.options.dask:
            bag_folder = str(self._new_bag_folder().resolve())
        self._running.add(key)
        self.store.claim(key, candidate.input_hash(files, self.options), candidate.files)
        return Unit(
            *key, files, seed=candidate.seed, field=self.options.field,
            bags=self.options.bags, bag_folder=bag_folder,
            trust=self.options.trust, alone=alone,
        )  # fmt: skip

    def _done(self, unit: Unit, result: UnitResult) -> None:
        if unit.canary:
            if result.disk_full:
                self._stop_if_disk_full(unit)
            self._follow(self._canaries.done(unit, result, self._waiting()))
            return
        self._running.discard(unit.key)
        try:
            self._submission_done(unit, result)
            for key in self._waiting():  # the group's others, in case this is interrupted
                if (self.candidates[key].leader, key[1]) == unit.key:
                    self._left_to_leader(key)
        except Exception as error:  # of one result; the others are not held up
            if is_disk_full(error):
                raise
            why = f"{type(error).__name__}: {error}"
            self._hold(unit.key, f"the result could not be stored ({why})")

    def _follow(self, verdict: Verdict) -> None:
        if verdict.note:
            self.store.note(verdict.note)
            self.progress.say(verdict.note)
        self.store.quarantine(verdict.again)
        for key in dict.fromkeys(verdict.held):
            self._hold(key, verdict.why)

    def _submission_done(self, unit: Unit, result: UnitResult) -> None:
        if result.died:
            self._died(unit, result.problem)
            return
        if result.disk_full:
            self._stop_if_disk_full(unit)
        problem = result.problem if result.grading is None else unjudged(result.grading)
        if stalled(result.grading):
            problem = f"{STALLS}; {problem}"
        elif problem:
            self._canaries.doubt(unit.exercise)  # was it the submission, or the grader?
        again = bool(problem) and self.store.counts(unit.key).unsure + 1 < MAX_UNSURE
        if problem and not again:
            problem = f"{problem}; {TWICE}"
        bags = self._store_bags(unit, result)  # also of one that is judged again: it may never be
        self.store.finish(
            unit.key, result.grading, problem=problem, again=again, recordings=bags,
            wall_s=result.wall_s,
        )  # fmt: skip
        if again:
            said = f"will retry, alone, at the end: {problem}"
            self.progress.done(*unit.key, said, over=False)
            return
        grading = result.grading or {}
        said = f"held: {problem}" if problem else f"{grading['score']}/{grading['max_score']}"
        self.progress.done(*unit.key, said)
        if why := self._canaries.graded(unit.key):
            self._hold(unit.key, why)

    def _stop_if_disk_full(self, unit: Unit) -> None:
        """Stop if there is still no space; else the unit itself may have taken it.

        Raises DiskFull: the disk is full with the unit over: the next one would end as it did.
        """
        if not self.options.dask and not has_space(self.out, Path(tempfile.gettempdir())):
            if not unit.canary:
                self.store.requeue(unit.key)
            raise DiskFull("no space is left")

    def _died(self, unit: Unit, why: str) -> None:
        counts = self.store.requeue(unit.key, death=True)
        if counts.deaths < MAX_DEATHS:
            self.progress.done(*unit.key, f"will retry: {why}", over=False)
            return
        self._hold(unit.key, f"{why}, {counts.deaths} times, at last with no other unit running")

    def _store_bags(self, unit: Unit, result: UnitResult) -> str | None:
        """Move the recordings to their place, which comes before the result is stored."""
        sent = unit.bag_folder or result.bags
        if not self.options.bags or result.grading is None or not sent:
            return None
        place = self.out / RECORDINGS / unit.student / unit.exercise
        part = Path(unit.bag_folder) if unit.bag_folder else self._unpacked(result.bags)
        shutil.rmtree(place, ignore_errors=True)
        place.parent.mkdir(parents=True, exist_ok=True)
        part.rename(place)
        return str(place.relative_to(self.out))

    def _unpacked(self, bags: bytes) -> Path:
        folder = self._new_bag_folder()
        with tarfile.open(fileobj=io.BytesIO(bags)) as archive:
            archive.extractall(folder, filter="data")
        return folder

    def _new_bag_folder(self) -> Path:
        self._bag_folders += 1
        folder = self.out / RECORDINGS / PARTS / str(self._bag_folders)
        folder.mkdir(parents=True)
        return folder

    # --- the same recordings, other checks -------------------------------------------------------

    def judge_again(self) -> None:
        """Judge stored recordings again, by the checks as they are now; no student's code runs."""
        old = {
            one.key: one
            for one in self.store.results()
            if one.state in (GRADED, HELD) and one.recordings is not None
        }  # fmt: skip  (others are for an ordinary run)
        units = [_saved(one, self.out) for key, one in old.items() if key in self.candidates]
        units = [unit for unit in units if Path(unit.saved).is_dir()]

        def done(unit: Unit, result: UnitResult) -> None:
            if result.grading is None:
                self.progress.done(*unit.key, f"as it was: {result.problem}")
                return
            before, candidate = old[unit.key].grading or {}, self.candidates[unit.key]
            input_hash = candidate.input_hash(candidate.read()[0], self.options)
            grading = {**result.grading, "isolation": before.get("isolation", "")}
            self.store.regraded(unit.key, grading, unjudged(grading), input_hash)
            score = f"{grading['score']}/{grading['max_score']}"
            self.progress.done(*unit.key, f"{score}, was {before.get('score', '-')}")

        self.progress.begin(len(units))
        left = iter(units)
        with engine.open_workers(self.options.workers) as workers:  # the bags are on this machine
            engine.run(workers, lambda _busy: next(left, None), done)


def _saved(result: StoredResult, out: Path) -> Unit:
    old = result.grading or {}
    return Unit(
        result.student,
        result.exercise,
        {},
        field=any(check["kind"] == "field" for check in old.get("checks", ())),
        saved=str(out / (result.recordings or "")),
    )


def has_space(*folders: Path) -> bool:
    """Return whether a grading may still be written to each of these folders."""
    found = [os.statvfs(folder) for folder in folders]
    return all(
        each.f_bavail * each.f_frsize >= MIN_SPACE
        and (each.f_favail >= MIN_FILES or not each.f_files)
        for each in found
    )
