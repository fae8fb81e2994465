"""Judge stored recordings again, with the checks as they are now. No student code runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from grader.classroom import engine
from grader.classroom.candidates import Candidate
from grader.classroom.engine import WorkerDied
from grader.classroom.options import Options
from grader.classroom.progress import Progress
from grader.classroom.row import GRADED, HELD, StoredResult
from grader.classroom.store import Key, Store
from grader.classroom.work import Unit, UnitResult, unjudged


def judge_again(
    store: Store,
    out: Path,
    candidates: Mapping[Key, Candidate],
    options: Options,
    progress: Progress,
) -> None:
    """Judge every submission that has recordings."""
    old = {
        (one.student, one.exercise): one
        for one in store.results()
        if one.state in (GRADED, HELD) and one.recordings is not None
    }  # others are for an ordinary run
    units = [_unit(one, out) for key, one in old.items() if key in candidates]
    units = [unit for unit in units if Path(unit.saved).is_dir()]
    hashes = {
        unit.key: candidates[unit.key].input_hash(candidates[unit.key].read()[0], options)
        for unit in units
    }

    def done(unit: Unit, result: UnitResult | WorkerDied) -> None:
        if isinstance(result, WorkerDied) or result.grading is None:
            why = str(result) if isinstance(result, WorkerDied) else result.problem
            progress.done(*unit.key, f"as it was: {why}")
            return
        before = old[unit.key].grading or {}
        grading = {**result.grading, "isolation": before.get("isolation", "")}
        store.regraded(unit.key, grading, unjudged(grading), hashes[unit.key])
        score = f"{grading['score']}/{grading['max_score']}"
        progress.done(*unit.key, f"{score}, was {before.get('score', '-')}")

    progress.begin(len(units))
    left = iter(units)
    with engine.open_workers(options.workers) as workers:  # the bags are on this machine
        engine.run(workers, lambda _busy: next(left, None), done)


def _unit(result: StoredResult, out: Path) -> Unit:
    """Return the unit that judges a result's recordings again."""
    old = result.grading or {}
    return Unit(
        result.student,
        result.exercise,
        {},
        field=any(check["kind"] == "field" for check in old.get("checks", ())),
        tier=int(old.get("tier", 1)),
        saved=str(out / (result.recordings or "")),
    )
