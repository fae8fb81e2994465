"""The pytest plugin that turns tests into checks: points, core and field, needs, six outcomes.

A check is a test under `grader/exercises/<exercise>/` with the mark of `grader.checks.check`::

    @check(points=10, asks="decision", task=3, scenarios=("zones",))
    def test_slow_zone(runs):
        \"\"\"Between 0.5 m and 1.0 m the robot drives at 0.15 m/s.\"\"\"

The first line of its docstring is what the student reads; it fails by `grader.checks.verdict.fail`.
Any other exception is the grader's own fault (ERROR). With `requires=("torch",)` it is judged only
where these libraries are installed; elsewhere it is UNAVAILABLE, and its scenarios don't run.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any

import pytest

from grader.checks.case import Oracle, Runs
from grader.checks.verdict import CheckFailed, Inconclusive, inconclusive
from grader.errors import GraderError, InputError
from grader.grading.limits import cpu_limit
from grader.recording import Recording
from grader.recording.words import words_of
from grader.trial.progress import CHECK, OnProgress, Step, ignore
from grader.trial.trials import NoRecording, TrialFault, Trials
from sim.toml_input import nearest

PASS, FAIL, SKIP, ERROR, INCONCLUSIVE = "pass", "fail", "skip", "error", "inconclusive"
UNAVAILABLE = "unavailable"  # a library that the check requires is not installed here
UNJUDGED = (ERROR, INCONCLUSIVE, UNAVAILABLE)  # neither won nor lost
MOST_CPU = 120.0  # [s] that one check may compute
MAX_MESSAGE = 4_000  # [characters]: messages quote what students wrote


@dataclass(frozen=True)
class Check:
    """A check, from its mark and its docstring."""

    id: str
    title: str
    points: int
    field: bool
    scenarios: tuple[str, ...]
    needs: tuple[str, ...]
    requires: tuple[str, ...] = ()  # modules of optional libraries
    asks: str = ""  # one of grader.checks.check.Asks
    task: int = 0  # the README's number; 0: all
    hint: str = ""  # where it stands in hints.md, "3.1": task and number

    @property
    def kind(self) -> str:
        """`core` (points) or `field` (the badge)."""
        return "field" if self.field else "core"


@dataclass(frozen=True)
class CheckResult:
    """The verdict of one check; its fields are the JSON's."""

    id: str
    title: str
    kind: str
    points: int
    max_points: int
    outcome: str
    message: str = ""
    expected: str = ""
    actual: str = ""
    time: float | None = None  # [s]
    help: str = ""
    scenario: str | None = None
    where: str = ""  # the student's lines that were being run, innermost first
    log: str = ""  # what the node said around that time
    asks: str = ""
    task: int = 0
    hint: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the JSON object of this result."""
        return asdict(self)


class CheckPlugin:
    """Collects the checks, gives them recordings and stores their outcomes."""

    def __init__(
        self,
        trials: Trials,
        *,
        field: bool,
        only: Iterable[str] = (),
        on_progress: OnProgress = ignore,
        exercise: str = "",
        essential: Sequence[str] = (),
        oracle: Oracle = lambda recording: (),
    ) -> None:
        self._trials = trials
        self._exercise, self._oracle = exercise, cache(oracle)  # many checks ask about one
        self._essential = essential
        self._field = field
        self._only = tuple(only)
        self._on_progress = on_progress
        self._checks: dict[str, Check] = {}  # by node id
        self._lacks: dict[str, str] = {}  # by check id: the libraries that are not installed
        self._died: set[str] = set()  # checks that failed because a message killed the node
        self._spared: set[str] = set()  # checks not judged since the grader failed in a trial
        self.results: dict[str, CheckResult] = {}  # by check id
        self.fault: Exception | None = None  # why the checks could not be collected
        self.interrupted = False  # by the person at the keyboard

    def pytest_configure(self, config: pytest.Config) -> None:
        """Register the mark."""
        config.addinivalue_line(
            "markers",
            "check(points, field, scenarios, needs, requires, asks, task, hint): one check",
        )
        config.option.tbstyle = "native"  # nobody reads it, and pytest's own takes 20 ms

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Select the checks, order each after those it needs, and start their trials."""
        try:
            checks = {item.nodeid: _read_check(item) for item in items}
            chosen = self._choose(list(checks.values()))
            self._lacks = {check.id: self._lacking(check) for check in chosen}
        except (GraderError, InputError) as error:
            self.fault, items[:] = error, []
            return
        by_id = {checks[item.nodeid].id: item for item in items}
        items[:] = [by_id[check.id] for check in chosen]
        self._checks = {item.nodeid: checks[item.nodeid] for item in items}
        self._prepare(field=False)

    @pytest.fixture
    def runs(self, recordings: tuple[Recording, ...]) -> Runs:
        """The recordings of the check's scenarios, with the exercise's oracle."""
        return Runs(recordings, self._oracle, self._exercise)

    @pytest.fixture
    def recordings(self, request: pytest.FixtureRequest) -> tuple[Recording, ...]:
        """The recordings of the check's scenarios, in the order of the mark."""
        check = self._checks[request.node.nodeid]
        return tuple(self._trials.get(name) for name in check.scenarios)

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Skip a check if a check it needs did not pass; field checks need all core checks."""
        check = self._checks[item.nodeid]
        if self._lacks[check.id]:
            raise _Unavailable(self._lacks[check.id])
        for need in check.needs:
            result = self.results[need]
            if result.outcome == UNAVAILABLE:
                raise _Unavailable(result.message)
            if need in self._spared:  # by a trial of its own: this check has others
                continue
            if result.outcome in UNJUDGED:
                inconclusive(f"not judged, because “{result.title}” could not be judged")
            if need in self._died and self._lived(check):
                continue
            if result.outcome != PASS:
                raise _Unmet(f"not judged, because “{result.title}” did not pass")
        if check.field:
            core = [result for result in self.results.values() if result.kind == "core"]
            if any(result.outcome not in (PASS, UNAVAILABLE) for result in core):
                raise _Unmet("not judged, because not every core check passed")
            self._prepare(field=True)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, Any, None]:
        """Judge, within a limit: a node's messages may be made to keep the judge busy."""
        with cpu_limit(MOST_CPU):
            yield

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, Any, None]:
        """Store the outcome."""
        yield
        check = self._checks[item.nodeid]
        if call.when == "teardown" or check.id in self.results:
            return
        if call.excinfo is not None:
            error = call.excinfo.value
            error = self._excused(check, error)
            self.results[check.id] = self._with_log(_judge(check, error))
            if isinstance(error, TrialFault):
                self._spared.add(check.id)
            if _died_of_one(check, error):
                self._died.add(check.id)
        elif call.when == "call":
            self.results[check.id] = _result(check, PASS)
        else:
            return
        done, outcome = len(self.results), self.results[check.id].outcome
        self._on_progress(Step(CHECK, done, len(self._checks), check.id, outcome))

    def _lived(self, check: Check) -> bool:
        """Return whether the node lived on to the end of all of a check's trials."""
        return all(self._trials.get(name).outcome.completed for name in check.scenarios)

    def _with_log(self, result: CheckResult) -> CheckResult:
        """Quote what the node itself said at the moment of a failure."""
        if result.outcome != FAIL or result.scenario is None:
            return result
        said = words_of(self._trials.get(result.scenario), result.time)
        return replace(result, log="\n".join(said)[:MAX_MESSAGE])

    def _excused(self, check: Check, error: BaseException) -> BaseException:
        """Return the error; an `Inconclusive` instead if the machine may have caused it."""
        if not isinstance(error, CheckFailed):
            return error
        for name in check.scenarios:
            live = self._trials.get(name).live
            if live is not None and live.stall:
                return Inconclusive(f"the machine stalled in {name}: {live.stall}")
        return error

    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """Note an interrupt, but not pytest's own subclass, raised for broken test files."""
        self.interrupted = excinfo.type is KeyboardInterrupt

    def _prepare(self, *, field: bool) -> None:
        checks = [check for check in self._checks.values() if check.field == field]
        checks = [check for check in checks if not self._lacks[check.id]]
        self._trials.prepare(list(dict.fromkeys(s for check in checks for s in check.scenarios)))

    def _lacking(self, check: Check) -> str:
        return self._trials.lacks(check.scenarios, check.requires)

    def _choose(self, checks: list[Check]) -> list[Check]:
        by_id = {check.id: check for check in checks}
        if len(by_id) != len(checks):
            raise GraderError("two checks of one exercise have the same name")
        for name in self._essential:
            if name not in by_id:
                where = f"exercises/{self._exercise}/exercise.toml: essential.checks"
                raise InputError(f"{where}: no check {name!r}{nearest(name, by_id)}")
        for wanted in self._only:
            if wanted not in by_id:
                raise InputError(f"unknown check {wanted!r}; there are: {', '.join(by_id)}")
        in_order = sorted(checks, key=lambda check: check.field)
        wanted_ids = self._only or [c.id for c in in_order if self._field or not c.field]
        chosen: dict[str, Check] = {}
        for check_id in wanted_ids:
            _add_with_needs(check_id, by_id, chosen)
        return list(chosen.values())


class _Unmet(Exception):
    """A check that another check needs did not pass."""


class _Unavailable(Exception):
    """A library that the check requires is not installed."""


def _add_with_needs(
    check_id: str, by_id: dict[str, Check], chosen: dict[str, Check], way: tuple[str, ...] = ()
) -> None:
    if check_id in chosen:
        return
    if check_id in way:
        raise GraderError(f"the check {check_id!r} needs itself")
    if check_id not in by_id:
        raise GraderError(f"a check needs {check_id!r}, which does not exist")
    for need in by_id[check_id].needs:
        _add_with_needs(need, by_id, chosen, (*way, check_id))
    chosen[check_id] = by_id[check_id]


def _read_check(item: pytest.Item) -> Check:
    mark = item.get_closest_marker("check")
    if mark is None or not isinstance(item, pytest.Function):
        raise GraderError(f"{item.nodeid} has no check mark")
    if "scenarios" not in mark.kwargs:
        raise GraderError(f"{item.nodeid} names no scenarios")
    doc = (item.function.__doc__ or "").strip()
    if not doc:
        raise GraderError(f"{item.nodeid} has no docstring: nothing for the student to read")
    return Check(
        id=item.name.removeprefix("test_"),
        title=doc.splitlines()[0].strip(),
        points=mark.kwargs.get("points", 0),
        field=mark.kwargs.get("field", False),
        scenarios=tuple(mark.kwargs["scenarios"]),
        needs=tuple(mark.kwargs.get("needs", ())),
        requires=tuple(mark.kwargs.get("requires", ())),
        asks=mark.kwargs.get("asks", ""),
        task=mark.kwargs.get("task", 0),
        hint=mark.kwargs.get("hint", ""),
    )


def _died_of_one(check: Check, error: BaseException) -> bool:
    """Return whether this root check failed because a message killed the node."""
    return isinstance(error, CheckFailed) and bool(error.title) and not check.needs


def _judge(check: Check, error: BaseException) -> CheckResult:
    match error:
        case CheckFailed():
            return _result(
                check,
                FAIL,
                message=error.message,
                expected=error.expected,
                actual=error.actual,
                time=error.at,
                help=error.help,
                scenario=error.scenario,
                where=error.where,
                **({"title": error.title} if _died_of_one(check, error) else {}),
            )
        case Inconclusive():
            return _result(check, INCONCLUSIVE, message=str(error))
        case _Unavailable():
            return _result(check, UNAVAILABLE, message=str(error))
        case _Unmet() | NoRecording():
            return _result(check, SKIP, message=str(error))
        case TrialFault():
            return _result(check, ERROR, message=str(error))
        case _:
            said = f"{type(error).__name__}: {error}"
            return _result(check, ERROR, message=f"the grader failed here: {said}")


def _result(check: Check, outcome: str, **details: Any) -> CheckResult:
    texts: dict[str, Any] = {
        key: value[:MAX_MESSAGE] if isinstance(value, str) else value
        for key, value in details.items()
    }
    return CheckResult(
        id=check.id,
        title=texts.pop("title", check.title),
        kind=check.kind,
        points=check.points if outcome == PASS else 0,
        max_points=check.points,
        outcome=outcome,
        asks=check.asks,
        task=check.task,
        hint=check.hint,
        **texts,
    )
