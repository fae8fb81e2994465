"""How a node counts, measures and writes, by what it reports of plain calls."""

import math
from collections.abc import Callable, Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.latency_monitor import habits as checked
from grader.exercises.latency_monitor.contract import ERROR, KEYS, OK, WARN, right_statistics
from grader.exercises.latency_monitor.evidence import require_single_calls
from grader.exercises.latency_monitor.habits import (
    LAST,
    RIGHT,
    Habits,
    Window,
    habits_of,
    levels_follow,
    misses_follow,
)
from grader.exercises.latency_monitor.reports import (
    RIGHT_FORM,
    Form,
    Report,
    _pairs,
    _reports_of,
)
from grader.recording import Inference

SLOW = (1.0, 5.0, 7.0)  # each second has slower ones
CALLS = [(0.05 * i, 5.0 + SLOW[i // 21 % 3] * (i % 6)) for i in range(1, 63)]  # [s], [ms]
TIMES = (1.02, 2.02, 3.02)  # [s] of the reports


class Recorded(SimpleNamespace):
    __hash__ = object.__hash__


def recorded(deadline: float = 100.0) -> Any:
    calls = [
        Inference("predict", "m", int(at * 1e9), int((at + ms / 1e3) * 1e9), int(ms * 1e6), (0.1,))
        for at, ms in CALLS
    ]
    scenario = SimpleNamespace(node=SimpleNamespace(parameters={"deadline_ms": deadline}))
    return Recorded(live=None, slack=0.0, scenario=scenario, inferences=calls)


def measured(calls: int = 100, since: float = 0.0) -> Iterable[tuple[float, list[float]]]:
    """Return the latencies [ms] that each report is about."""
    for time in TIMES:
        ended = [ms for at, ms in CALLS if since * (time - 1.0) < at + ms / 1e3 <= time]
        yield time, ended[-calls:]


def said(found: list[float], scale: float = 1.0, deadline: float = 100.0) -> dict[str, str]:
    scaled = [scale * ms for ms in found]
    p50, p95, p99 = np.percentile(scaled, (50, 95, 99))
    numbers = (len(scaled), np.mean(scaled), p50, p95, p99, max(scaled), deadline)
    late = sum(ms > deadline for ms in scaled)
    return dict(zip(KEYS, (f"{number:.3f}" for number in (*numbers, late)), strict=True))


@pytest.fixture
def report(monkeypatch: pytest.MonkeyPatch) -> Callable[[list[Report]], None]:
    def say(reports: list[Report]) -> None:
        monkeypatch.setattr(checked, "require_reports", lambda *_: reports)
        monkeypatch.setattr(checked, "form_of", lambda _: RIGHT_FORM)

    return say


def reports(
    window: Iterable[tuple[float, list[float]]], scale: float = 1.0, deadline: float = 100.0
) -> list[Report]:
    return [
        Report(time, OK, said(found, scale, deadline), since=time - 1.0) for time, found in window
    ]


Say = Callable[[list[Report]], None]


def test_a_right_node_has_the_contracts_habits(report: Say) -> None:
    report(reports(measured()))
    assert habits_of(recorded()) == RIGHT


@pytest.mark.parametrize(
    ("window", "calls", "since"), [(Window(50), 50, 0.0), (Window(cleared=True), 100, 1.0)]
)
def test_the_window_is_found(report: Say, window: Window, calls: int, since: float) -> None:
    report(reports(measured(calls, since)))
    assert habits_of(recorded()) == Habits(window=window, right=False)


@pytest.mark.parametrize(("calls", "since"), [(1, 0.0), (4, 0.0)])
def test_a_window_of_very_few_calls_is_none(report: Say, calls: int, since: float) -> None:
    report(reports(measured(calls, since)))
    assert habits_of(recorded()) == Habits(right=False)


def test_who_counts_on_one_call_counts_all_the_same(report: Say) -> None:
    report(reports(measured(1)))
    assert habits_of(recorded(), fewest=1).window == Window(1)


def test_nearly_no_call_is_no_window(report: Say) -> None:
    zeros = dict.fromkeys(KEYS, "0.0") | {"count": "0.05"}
    report([Report(time, OK, zeros) for time, _ in measured()])
    assert habits_of(recorded()) == Habits(right=False)


@pytest.mark.parametrize("scale", [1e-3, 1e3, 1e6, 2.0])
def test_the_unit_is_found(report: Say, scale: float) -> None:
    report(reports(measured(), scale))
    found = habits_of(recorded())
    assert found.window == LAST
    assert found.scale == pytest.approx(scale)
    assert not found.right


@pytest.mark.parametrize("scale", [1e-4, 0.0, 1e12, -1.0])
def test_a_unit_that_leaves_nothing_to_judge_is_none(report: Say, scale: float) -> None:
    report(reports(measured(), scale))
    assert habits_of(recorded()) == Habits(right=False)


def test_other_latencies_are_no_unit(report: Say) -> None:
    report(reports((time, [ms % 11.0 for ms in found]) for time, found in measured()))
    assert habits_of(recorded()) == Habits(right=False)


def levelled(scale: float, deadline: float, level: int | None = None) -> list[Report]:
    found = reports(measured(), scale, deadline)
    return [
        Report(
            each.t,
            (ERROR if each.number("p95_ms") > deadline else WARN if each.number("missed") else OK)
            if level is None
            else level,
            each.texts,
        )
        for each in found
    ]


def both(report: Say, monkeypatch: pytest.MonkeyPatch, first: list[Report], second: Any) -> Any:
    """Two recordings, with deadlines of 10 and of 0.01 ms."""
    strict, loose = recorded(10.0), recorded(0.01)
    report([])
    monkeypatch.setattr(
        checked, "require_reports", lambda which, _: first if which is strict else second
    )
    return strict, loose


def test_what_follows_from_seconds_is_right_for_seconds(
    report: Say, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = levelled(1e-3, 10.0), levelled(1e-3, 0.01)
    recordings = both(report, monkeypatch, *said)
    assert levels_follow(recordings, Habits(right=False))
    assert misses_follow(recordings, Habits(right=False))


@pytest.mark.parametrize("level", [OK, WARN, ERROR])
def test_one_level_for_all_does_not_follow(
    report: Say, monkeypatch: pytest.MonkeyPatch, level: int
) -> None:
    said = levelled(1e-3, 10.0, level), levelled(1e-3, 0.01, level)
    assert not levels_follow(both(report, monkeypatch, *said), Habits(right=False))


@pytest.mark.parametrize("missed", ["0", "63", "-1", "nan", "1e9", ""])
def test_misses_that_the_percentiles_deny_do_not_follow(
    report: Say, monkeypatch: pytest.MonkeyPatch, missed: str
) -> None:
    first, second = levelled(1e-3, 10.0), levelled(1e-3, 0.01)
    second[1].texts["missed"] = missed
    assert not misses_follow(both(report, monkeypatch, first, second), Habits(right=False))


def test_a_constant_tells_nothing(report: Say, monkeypatch: pytest.MonkeyPatch) -> None:
    always = [(time, [1.0] * (i + 1)) for i, time in enumerate(TIMES)]
    first = [Report(t, OK, said(found, 1.0, 10.0)) for t, found in always]
    second = [Report(t, ERROR, said(found, 1.0, 0.01)) for t, found in always]
    recordings = both(report, monkeypatch, first, second)
    assert not levels_follow(recordings, Habits(right=False))
    assert not misses_follow(recordings, Habits(right=False))


# --- the form -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("12.3", 12.3),
        ("12.3 ms", 12.3),
        ("12,3ms", 12.3),
        ("np.float64(12.3)", 12.3),
        ("p50: 12.3", 12.3),
        ("1.2e-05 s", 1.2e-5),
        ("-3 ms", -3.0),
        ("many", math.nan),
        ("", math.nan),
        ("1" * 10_000 + " ms", 1e40 / 9),
    ],
)
def test_numbers_are_read_as_a_person_would(text: str, number: float) -> None:
    loose = Report(0.0, OK, {"mean_ms": text}, exact=False).number("mean_ms")
    assert loose == pytest.approx(number, nan_ok=True)
    if " " in text:
        assert math.isnan(Report(0.0, OK, {"mean_ms": text}).number("mean_ms"))


def test_keys_are_known_by_likeness_and_by_place() -> None:
    written = ["Count", "average", "p50", "p95", "p99", "worst", "deadline", "missed_calls"]
    assert dict(_pairs(written)) == dict(zip(KEYS, written, strict=True))
    assert dict(_pairs(["p95_ms", "p99"])) == {"p95_ms": "p95_ms", "p99_ms": "p99"}
    assert dict(_pairs(["p95"])) == {"p95_ms": "p95"}
    assert dict(_pairs([])) == {}


def test_a_key_of_the_contract_stands_for_no_other() -> None:
    assert dict(_pairs(["max_ms", "p50_ms"])) == {"max_ms": "max_ms", "p50_ms": "p50_ms"}


def status(name: str, **values: str) -> Any:
    pairs = [SimpleNamespace(key=key, value=value) for key, value in values.items()]
    return SimpleNamespace(name=name, level=OK, values=pairs)


def test_the_form_of_plain_calls_is_that_of_all_reports() -> None:
    array = SimpleNamespace(status=[status("mine", p50="1 ms"), status("mine", count="2")])
    loose = Form((("p50_ms", "p50"), ("count", "count")), named=False, exact=False)
    (found,) = _reports_of(array, loose, 1.0, 0.0)
    assert (found.number("p50_ms"), found.number("count")) == (1.0, 2.0)
    assert _reports_of(array, RIGHT_FORM, 1.0, 0.0) == []
    (other,) = _reports_of(array, loose._replace(keys=(("p50_ms", "P50"),)), 1.0, 0.0)
    assert math.isnan(other.number("p50_ms"))


def test_of_calls_that_end_together_the_first_asked_counts_first() -> None:
    recording = recorded()
    end = 2 * 10**9
    recording.inferences = [
        Inference("predict", "m", end - took, end, took, (0.1,)) for took in (1_200_000_000, 0, 0)
    ]
    choices = right_statistics(recording, 2.0)
    assert [choice.latencies for choice in choices] == [
        (),
        (1200.0,),
        (1200.0, 0.0),
        (1200.0, 0.0, 0.0),
    ]


def test_a_second_call_for_a_scan_is_said() -> None:
    recording = recorded()
    recording.name = "latency_raises"
    recording.scans = lambda: [SimpleNamespace(t=0.05 * i) for i in range(len(CALLS) + 2)]
    require_single_calls(recording)

    recording.inferences = recording.inferences[:1] * 3
    with pytest.raises(CheckFailed, match="called again for the scan"):
        require_single_calls(recording)
