"""What reports in another unit, of nothing but 0, or of a window that empties are taken for."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.case import Case, exactly
from grader.exercises.latency_monitor import causes


def report(at: float, mean: float, said: float, count: float = 9.0, tag: str = "max_ms") -> Case:
    right = {"mean_ms": exactly(mean), "max_ms": exactly(2 * mean)}
    told = {"count": count, "mean_ms": said, "max_ms": 2 * said}
    return Case(at, "a report", frozenset({tag, "count"}), right, told)


def assert_seen(said: str, reports: list[Case], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(causes, "cases", lambda run: reports)
    run: Any = SimpleNamespace(name="latency_times", published=[])
    found = causes.seen({"latency_times": run}, ["mean_and_max"])
    assert said in (found.text if found else "")
    assert bool(found) == bool(said)
    assert causes.seen({"latency_times": run}, ["clipped"]) is None


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (0.1, "mean_ms is 10 times too small in each of 4 answers"),
        (1e6, "mean_ms is 1,000,000 times too big"),
        (0.0, "every latency is 0.00"),
        (1.0, ""),
        (0.5, ""),
    ],
)
def test_a_slip_of_units_is_seen_in_all_reports(
    factor: float, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    reports = [report(float(i), i + 1.0, factor * (i + 1)) for i in range(4)]
    assert_seen(said, reports, monkeypatch)


@pytest.mark.parametrize(
    ("counts", "tag", "said"),
    [
        ((20.0, 40.0, 20.0), "max_ms", "at 2.00 s of latency_times count falls from 40 to 20"),
        ((20.0, 100.0, 100.0), "max_ms", "every latency is 0.00"),
        ((0.0, 0.0, 0.0), "empty", ""),  # there was no call
    ],
)
def test_a_window_only_fills(
    counts: tuple[float, ...], tag: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    reports = [report(float(i), 1.0, 0.0, count, tag) for i, count in enumerate(counts)]
    assert_seen(said, reports, monkeypatch)
