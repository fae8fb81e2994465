"""Grade a class: queue, resume, watch the grader with known solutions, write the results."""

from __future__ import annotations

import contextlib
import fcntl
import io
import os
import shutil
import tarfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grader.classroom.canaries import STRIKES, CanaryRounds, canaries_of
from grader.classroom.conditions import HASHED, fingerprint, submission_hash
from grader.classroom.engine import DaskWorkers, LocalWorkers, WorkerDied, Workers, refusal, run
from grader.classroom.intake import Found, Student, find_files, find_students, read_file
from grader.classroom.progress import Progress
from grader.classroom.results import ResultOptions, write_results
from grader.classroom.row import GRADED, HELD, StoredResult
from grader.classroom.store import Key, Store
from grader.classroom.work import Unit, UnitResult, isolation_is_enough, judge_saved, why_held
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.students import student_seed
from grader.errors import GraderError, InputError
from grader.link.scratch import sweep

__all__ = ["Options", "autograde", "isolation_is_enough"]

DEATHS = 3  # of a unit's workers, after which it is left to a person
UNSURE = 2  # gradings that could not judge
QUARANTINES = 2
EVERY = 25  # units of an exercise between two rounds of canaries
STORE = "store.sqlite"
RECORDINGS = "recordings"
PARTS = ".part"  # below RECORDINGS: bags that are being written
UNPACKED = ".unpacked"  # archives, during a run


@dataclass(frozen=True)
class Options:
    """How a class is to be graded."""

    exercises: tuple[str, ...] = ()  # all of which somebody handed something in, if none
    workers: int = 1
    dask: str = ""  # a scheduler's address or file, instead of local workers
    secret: bytes | None = None  # every student gets worlds of their own
    field: bool = False
    tier: int = 1
    bags: bool = True
    trust: bool = False
    canaries: int = EVERY  # 0: none
    hide: str = "nothing"
    retry_held: bool = False


@dataclass(frozen=True)
class Candidate:
    """One student's files for one exercise, where they lie."""

    student: str
    exercise: Exercise
    found: Found
    seed: int | None

    def read(self) -> dict[str, bytes]:
        """Return the files."""
        return {name: read_file(path) for name, path in self.found.files.items()}


def autograde(
    submissions: Path, out: Path, options: Options, progress: Progress, *, regrade: bool = False
) -> list[StoredResult]:
    """Grade every submission that is new or changed; return all results.

    May be killed at any moment and called again: it goes on where it was. With `regrade` only the
    stored recordings are judged again, and no student's code runs.

    Raises
    ------
    InputError
        The submissions can't be read, or code would run without isolation.
    GraderError
        Another batch works on `out`, or no worker can be started.
    """
    out.mkdir(parents=True, exist_ok=True)
    scratch, parts = out / UNPACKED, out / RECORDINGS / PARTS
    with _locked(out), Store(out / STORE) as store, _emptied(scratch), _emptied(parts):
        sweep()
        store.give_back()
        candidates = _take_in(submissions, scratch, store, options, regrade)
        if options.retry_held and not regrade:
            store.retry_held()
        try:
            if regrade:
                _Regrade(store, out, candidates, options, progress).run()
            else:
                _Batch(store, out, candidates, options, progress).run()
        finally:
            store.give_back()
        results = store.results()
        notes = [*store.notes(), *_version_notes(results)]
        sources = {key: _sources(candidate) for key, candidate in candidates.items()}
        wanted = ResultOptions(
            hide=options.hide, notes=notes, sources=sources, workers=options.workers
        )
        write_results(results, out, wanted)
        return results


def _take_in(
    submissions: Path, scratch: Path, store: Store, options: Options, regrade: bool
) -> dict[Key, Candidate]:
    """Find everybody's files and put what is new or changed into the queue.

    To judge recordings again, it doesn't matter whether the grader is another than before.
    """
    students = find_students(submissions, scratch)
    named = [find_exercise(name) for name in options.exercises]
    found = {
        (student.id, exercise.slug): Candidate(
            student.id, exercise, find_files(student, exercise.files),
            None if options.secret is None
            else student_seed(options.secret, student.id, exercise.slug),
        )
        for student in students
        for exercise in dict.fromkeys(named or all_exercises())
    }  # fmt: skip
    if not named:
        handed_in = {key[1] for key, candidate in found.items() if candidate.found.files}
        if not handed_in:
            raise InputError(
                f"{submissions}: none of {len(students)} students has a file of any exercise; "
                f"{_first_problem(students, found)}"
            )
        found = {key: candidate for key, candidate in found.items() if key[1] in handed_in}
    prints = {key[1]: "" for key in found}
    prints = {slug: fingerprint(find_exercise(slug)) for slug in prints}
    for key, candidate in found.items():
        problem, files = candidate.found.problem, {}
        try:
            files = candidate.read()
        except OSError as error:
            problem = f"a file that can't be read ({error.strerror})"
        input_hash = _hash(candidate, files, options, prints[key[1]])
        store.enter(key, input_hash, problem=problem, compared=HASHED if regrade else None)
        if candidate.found.remark:
            store.note(f"{candidate.found.remark}.")
    gone = store.keep_only(found, {key[1] for key in found})
    if gone:
        store.note(f"{gone} earlier results were dropped: their students are no longer there.")
    return found


def _first_problem(students: Sequence[Student], found: Mapping[Key, Candidate]) -> str:
    problem = next((c.found.problem for c in found.values() if c.found.problem), "")
    return f"{students[0].id}: {problem}"


def _hash(
    candidate: Candidate, files: Mapping[str, bytes], options: Options, conditions: str
) -> str:
    of_files = submission_hash(
        candidate.exercise, files, seed=candidate.seed, field=options.field, tier=options.tier
    )
    return f"{of_files}{conditions}"


class _Batch:
    """One run over the queue."""

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
        self._rooms = 0
        self._prints = {key[1]: "" for key in candidates}
        self._all_rounds: dict[str, CanaryRounds] = {}

    def run(self) -> None:
        """Grade what waits."""
        waiting = self._waiting()
        self._progress.begin(len(waiting))
        unverified = [slug for slug in self._prints if self._store.unverified(slug)]
        if not waiting and not (self._options.canaries and unverified):
            return
        for slug in self._prints:
            exercise = find_exercise(slug)
            self._prints[slug] = fingerprint(exercise)
            if self._options.canaries:
                self._all_rounds[slug] = self._rounds_of(exercise)
        with _workers(self._options) as workers:
            if not self._options.trust and (problem := refusal(workers)):
                raise InputError(problem)
            run(workers, self._next, self._done)

    def _rounds_of(self, exercise: Exercise) -> CanaryRounds:
        sample = Unit("", exercise.slug, {}, field=self._options.field, tier=self._options.tier)
        sample = replace(sample, trust=self._options.trust)
        canaries = canaries_of(exercise, sample)
        if not canaries:
            self._store.note(f"{exercise.slug}: without its solutions, no canaries were graded.")
        return CanaryRounds(canaries, self._options.canaries, trusted=not canaries)

    def _waiting(self) -> list[Key]:
        known = (key for key in self._store.waiting() if key in self._candidates)
        return [key for key in known if key not in self._running]

    def _next(self, busy: bool) -> Unit | None:
        waiting = self._waiting()
        for slug, rounds in self._all_rounds.items():
            if rounds.waiting:
                return rounds.next()
            if rounds.in_round or not rounds.canaries:
                continue
            mine = [key for key in waiting if key[1] == slug]
            covers = self._store.unverified(slug)
            running = any(key[1] == slug for key in self._running)
            if (mine and rounds.due) or (covers and not mine and not running):
                rounds.begin(covers)
                return rounds.next()
        for key in waiting:
            rounds_or_none = self._all_rounds.get(key[1])
            if rounds_or_none is not None and not rounds_or_none.trusted:
                continue
            alone = self._store.counts(key).deaths >= DEATHS - 1
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
            self._store.hold(key, f"a file that can't be read any more ({error.strerror})")
            return None
        local, room = not self._options.dask, ""
        if self._options.bags and local:
            self._rooms += 1
            folder = (self._out / RECORDINGS / PARTS / str(self._rooms)).resolve()
            folder.mkdir(parents=True)
            room = str(folder)
        self._running.add(key)
        input_hash = _hash(candidate, files, self._options, self._prints[key[1]])
        self._store.claim(key, input_hash, files)
        return Unit(
            *key, files, seed=candidate.seed, field=self._options.field, tier=self._options.tier,
            bags=self._options.bags, room=room, trust=self._options.trust, alone=alone,
        )  # fmt: skip

    def _done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        if unit.canary:
            self._canary_done(unit, result)
            return
        self._running.discard(unit.key)
        if isinstance(result, WorkerDied):
            self._died(unit, result)
            return
        problem = result.problem if result.grading is None else why_held(result.grading)
        rounds = self._all_rounds.get(unit.exercise)
        if problem:
            if rounds is not None:
                rounds.asked = True  # was it the submission, or the machine?
            if self._store.put_off(unit.key, unsure=True).unsure < UNSURE:
                self._tell(unit, f"put off: {problem}", counts=False)
                return
        self._keep(unit, result, problem)
        if rounds is not None:
            rounds.since += 1
            if rounds.strikes >= STRIKES:  # it was running when the grader was found out
                self._store.hold(unit.key, "the grader could not be trusted while it ran")

    def _keep(self, unit: Unit, result: UnitResult, problem: str) -> None:
        self._store.finish(
            unit.key,
            result.grading,
            problem=problem,
            recordings=self._put_bags(unit, result),
            cpu_s=result.cpu_s,
            wall_s=result.wall_s,
            worker=result.worker,
        )
        if problem:
            self._tell(unit, f"held: {problem}")
        elif result.grading is not None:
            self._tell(unit, f"{result.grading['score']}/{result.grading['max_score']}")

    def _died(self, unit: Unit, why: WorkerDied) -> None:
        counts = self._store.put_off(unit.key, death=True)
        if counts.deaths < DEATHS:
            self._tell(unit, f"put off: {why}", counts=False)
            return
        problem = f"{why}, {counts.deaths} times, the last time with nothing beside it"
        self._store.hold(unit.key, problem)
        self._tell(unit, f"held: {problem}")

    def _put_bags(self, unit: Unit, result: UnitResult) -> str | None:
        """Move the recordings to their place; only then is the result put down."""
        if not self._options.bags or result.grading is None:
            return None
        place = self._out / RECORDINGS / unit.student / unit.exercise
        part = Path(unit.room) if unit.room else self._unpacked(result.bags)
        shutil.rmtree(place, ignore_errors=True)
        place.parent.mkdir(parents=True, exist_ok=True)
        part.rename(place)
        return str(place.relative_to(self._out))

    def _unpacked(self, bags: bytes) -> Path:
        self._rooms += 1
        folder = self._out / RECORDINGS / PARTS / str(self._rooms)
        folder.mkdir(parents=True)
        with tarfile.open(fileobj=io.BytesIO(bags)) as archive:
            archive.extractall(folder, filter="data")
        return folder

    def _canary_done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        rounds = self._all_rounds[unit.exercise]
        canary = rounds.out.pop(unit.key)
        if isinstance(result, WorkerDied):
            result = UnitResult(None, f"could not be graded: {result}")
        drift = canary.drift(result.grading, result.problem)
        self._store.canary(unit.key, result.grading, drift, result.cpu_s)
        if drift:
            rounds.drifts.append(f"the known solution {unit.student.lstrip('.')} {drift}")
        if not rounds.in_round:
            self._round_over(unit.exercise, rounds)

    def _round_over(self, slug: str, rounds: CanaryRounds) -> None:
        if not rounds.drifts:
            rounds.trusted, rounds.strikes = True, 0
            self._store.verify(rounds.covers)
            return
        rounds.trusted = False
        rounds.strikes += 1
        why = "; ".join(rounds.drifts)
        again = self._store.unverified(slug)
        if rounds.strikes < STRIKES:
            self._remark(
                f"{slug}: {why}. What was graded since the last good canary ({len(again)} "
                "submissions) was put in quarantine and graded again."
            )
        hopeless = [key for key in again if self._store.counts(key).quarantines >= QUARANTINES - 1]
        self._store.quarantine(key for key in again if key not in hopeless)
        if rounds.strikes >= STRIKES:
            hopeless += [key for key in self._waiting() if key[1] == slug]
            rounds.canaries, rounds.trusted = [], False
            self._remark(f"{slug}: {why}, {rounds.strikes} times in a row; held for a person.")
        for key in dict.fromkeys(hopeless):
            self._store.hold(key, f"the grader could not be trusted: {why}")

    def _remark(self, text: str) -> None:
        self._store.note(text)
        self._progress.say(text)

    def _tell(self, unit: Unit, outcome: str, *, counts: bool = True) -> None:
        self._progress.done(unit.student, unit.exercise, outcome, counts=counts)


class _Regrade:
    """Judge stored recordings again, with the checks as they are now."""

    def __init__(
        self,
        store: Store,
        out: Path,
        candidates: Mapping[Key, Candidate],
        options: Options,
        progress: Progress,
    ) -> None:
        self._store = store
        self._progress = progress
        self._workers = options.workers
        self._options = options
        slugs = dict.fromkeys(key[1] for key in candidates)
        prints = {slug: fingerprint(find_exercise(slug)) for slug in slugs}
        self._hashes = {
            key: _hash(candidate, _sources(candidate), options, prints[key[1]])
            for key, candidate in candidates.items()
        }
        kept = [result for result in store.results() if result.recordings is not None]
        self._old = {(result.student, result.exercise): result for result in kept}
        folders = {key: out / str(result.recordings) for key, result in self._old.items()}
        self._units = [
            judge_saved(self._old[key], folder)
            for key, folder in folders.items()
            if key in candidates and folder.is_dir()
        ]

    def run(self) -> None:
        """Judge all that have recordings."""
        self._progress.begin(len(self._units))
        left = iter(self._units)
        with _workers(replace(self._options, dask="")) as workers:
            run(workers, lambda _busy: next(left, None), self._done)

    def _done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        if isinstance(result, WorkerDied) or result.grading is None:
            why = str(result) if isinstance(result, WorkerDied) else result.problem
            self._progress.done(*unit.key, f"as it was: {why}")
            return
        before = self._old[unit.key].grading or {}
        grading = {**result.grading, "isolation": before.get("isolation", "")}
        self._store.regraded(unit.key, grading, why_held(grading), self._hashes[unit.key])
        score = f"{grading['score']}/{grading['max_score']}"
        self._progress.done(*unit.key, f"{score}, was {before.get('score', '-')}")


@contextlib.contextmanager
def _workers(options: Options) -> Iterator[Workers]:
    workers: Workers = DaskWorkers(options.dask) if options.dask else LocalWorkers(options.workers)
    try:
        yield workers
    except BaseException:
        workers.close(now=True)
        raise
    workers.close(now=False)


@contextlib.contextmanager
def _locked(out: Path) -> Iterator[None]:
    """Keep other batches away from the folder until this process ends, however it does."""
    fd = os.open(out / ".lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(fd)
        raise GraderError(f"{out}: another `course autograde` works on it") from None
    try:
        yield
    finally:
        os.close(fd)


@contextlib.contextmanager
def _emptied(folder: Path) -> Iterator[None]:
    """Begin without what a killed run left behind, and leave nothing."""
    shutil.rmtree(folder, ignore_errors=True)
    try:
        yield
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _sources(candidate: Candidate) -> dict[str, bytes]:
    try:
        return candidate.read()
    except OSError:
        return {}


def _version_notes(results: Sequence[StoredResult]) -> list[str]:
    """Say so if workers with other versions graded parts of the class."""
    seen = {
        tuple(sorted(result.grading["versions"].items()))
        for result in results
        if result.grading is not None and result.state in (GRADED, HELD)
    }
    if len(seen) < 2:
        return []
    names = {name for versions in seen for name, _ in versions}
    differ = sorted(n for n in names if len({dict(v).get(n, "none") for v in seen}) > 1)
    return [f"The class was graded with different versions of {', '.join(differ)}."]
