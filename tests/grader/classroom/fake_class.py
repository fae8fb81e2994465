"""A class graded by a fake judge: what the tests of the batch share."""

import contextlib
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future
from pathlib import Path
from typing import Any

import pytest
from handing_in import AGENT as FILE
from handing_in import put
from payloads import check

from grader.classroom.batch import autograde
from grader.classroom.options import Options
from grader.classroom.queue import engine
from grader.classroom.queue.canaries import canaries_of
from grader.classroom.queue.work import Unit, UnitResult
from grader.classroom.row import StoredResult
from grader.course.exercises import find_exercise
from grader.grading.handed_in import isolation_problem

SLUG = "obstacle_avoidance"
MUTANT_FAILS = canaries_of(find_exercise(SLUG), Unit("", SLUG, {}))[-1].fails

Judge = Callable[[Unit], UnitResult]


class Quiet:
    """A progress display that writes down what it is told."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def begin(self, total: int, before: int = 0) -> None:
        self.lines.append(f"{total} to grade")

    def done(self, student: str, exercise: str, outcome: str, *, over: bool = True) -> None:
        self.lines.append(f"{student}: {outcome}")

    def say(self, text: str) -> None:
        self.lines.append(text)


class FakeWorkers:
    """Runs the fake judge on the spot."""

    slots = 2

    def __init__(self, judge: Judge, refusal: str = "") -> None:
        self.judge = judge
        self.refusal = refusal
        self.seen: list[Unit] = []

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if task is isolation_problem:
            future.set_result(self.refusal)
            return future
        (unit,) = arguments
        self.seen.append(unit)
        if unit.bag_folder:
            Path(unit.bag_folder, "trial").mkdir(exist_ok=True)
        try:
            future.set_result(self.judge(unit))
        except BrokenExecutor as error:
            future.set_exception(error)
        return future

    @property
    def students(self) -> list[str]:
        return [unit.student for unit in self.seen if not unit.canary]


def grading(*failed: str, outcome: str = "fail", score: int = 100) -> dict[str, Any]:
    because = {"points": 0, "max_points": 5, "message": "because"}
    checks = [check(name, name, outcome, **because) for name in failed]
    return {
        "exercise": SLUG, "file": FILE, "tier": 1, "score": score, "max_score": 100,
        "provisional": False, "field_ready": None, "isolation": "all", "notes": [],
        "checks": checks, "recordings": [], "versions": {"python": "3"},
    }  # fmt: skip


def fair(unit: Unit) -> UnitResult:
    return UnitResult(grading(*MUTANT_FAILS) if unit.student == ".mutant" else grading())


def but(student: str, found: UnitResult) -> Judge:
    """Return a judge who is fair to all but one."""
    return lambda unit: found if unit.student == student else fair(unit)


def until(student: str) -> Judge:
    """Return a fair judge who is interrupted when a student's work comes."""

    def judge(unit: Unit) -> UnitResult:
        if unit.student == student:
            raise KeyboardInterrupt
        return fair(unit)

    return judge


class Drifting:
    """A judge that is wrong about the reference once, after the class: all are graded again."""

    def __init__(self) -> None:
        self.rounds = 0

    def __call__(self, unit: Unit) -> UnitResult:
        self.rounds += unit.student == ".reference"
        wrong = unit.student == ".reference" and self.rounds == 2
        return UnitResult(grading("stop_zone")) if wrong else fair(unit)


@pytest.fixture
def handed_in(tmp_path: Path) -> Path:
    return put(tmp_path / "in", *(f"{name}/{FILE}" for name in ("ann", "bob", "eve")))


@pytest.fixture
def grade_class(
    handed_in: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., tuple[dict[str, StoredResult], FakeWorkers, Quiet]]:
    def grade(
        judge: Judge = fair, *, regrade: bool = False, refusal: str = "", **options: Any
    ) -> tuple[dict[str, StoredResult], FakeWorkers, Quiet]:
        workers, quiet = FakeWorkers(judge, refusal), Quiet()

        @contextlib.contextmanager
        def fake_workers(*_: object) -> Iterator[FakeWorkers]:
            yield workers

        monkeypatch.setattr(engine, "open_workers", fake_workers)
        options.setdefault("exercises", (SLUG,))
        options.setdefault("canaries", 0)
        graded = autograde(
            [handed_in], tmp_path / "out", Options(**options), quiet, regrade=regrade
        )
        return {r.student: r for r in graded.results}, workers, quiet

    return grade
