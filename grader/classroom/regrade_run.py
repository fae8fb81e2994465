"""Judge stored recordings again, with the checks as they are now. No student code runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from grader.classroom import engine
from grader.classroom.candidates import Candidate
from grader.classroom.engine import WorkerDied
from grader.classroom.options import Options
from grader.classroom.progress import Progress
from grader.classroom.row import GRADED, HELD, StoredResult
from grader.classroom.store import Key, Store
from grader.classroom.work import Unit, UnitResult, unjudged


class RegradeRun:
    """One run over all stored recordings."""

    def __init__(
        self,
        store: Store,
        out: Path,
        candidates: Mapping[Key, Candidate],
        options: Options,
        progress: Progress,
        look: Callable[[], None] = lambda: None,
    ) -> None:
        self._store = store
        self._look = look  # called between units
        self._options = options
        self._progress = progress
        self._hashes = {
            key: candidate.input_hash(candidate.read_if_possible(), options)
            for key, candidate in candidates.items()
        }
        self._old: dict[Key, StoredResult] = {}
        self._units: list[Unit] = []
        for result in store.results():
            key = (result.student, result.exercise)
            judged = result.state in (GRADED, HELD)  # else an ordinary run will do it
            if key not in candidates or result.recordings is None or not judged:
                continue
            folder = out / result.recordings
            if folder.is_dir():
                self._old[key] = result
                self._units.append(_unit(result, folder))

    def run(self) -> list[str]:
        """Judge every submission that has recordings; nothing is to be said of that."""
        self._progress.begin(len(self._units))
        left = iter(self._units)
        with engine.open_workers(self._options.workers) as workers:  # the bags are on this machine
            engine.run(workers, lambda _busy: next(left, None), self._done)
        return []

    def _done(self, unit: Unit, result: UnitResult | WorkerDied) -> None:
        if isinstance(result, WorkerDied) or result.grading is None:
            why = str(result) if isinstance(result, WorkerDied) else result.problem
            self._progress.done(*unit.key, f"as it was: {why}")
            return
        before = self._old[unit.key].grading or {}
        grading = {**result.grading, "isolation": before.get("isolation", "")}
        self._store.regraded(unit.key, grading, unjudged(grading), self._hashes[unit.key])
        score = f"{grading['score']}/{grading['max_score']}"
        self._progress.done(*unit.key, f"{score}, was {before.get('score', '-')}")
        self._look()


def _unit(result: StoredResult, folder: Path) -> Unit:
    """Return the unit that judges a result's recordings again."""
    old = result.grading or {}
    return Unit(
        result.student,
        result.exercise,
        {},
        field=any(check["kind"] == "field" for check in old.get("checks", ())),
        tier=int(old.get("tier", 1)),
        saved=str(folder),
    )
