"""What reports in another unit, or of nothing but 0, are taken for."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.case import Case, exactly
from grader.exercises.latency_monitor import causes


def report(at: float, mean: float, said: float) -> Case:
    right = {"mean_ms": exactly(mean), "max_ms": exactly(2 * mean)}
    told = {"count": 9.0, "mean_ms": said, "max_ms": 2 * said}
    return Case(at, "a report", frozenset({"value"}), right, told)


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
    monkeypatch.setattr(causes, "cases", lambda run: reports)
    run: Any = SimpleNamespace(name="latency_times", published=[])

    found = causes.seen({"latency_times": run}, ["mean_and_max"])

    assert said in (found.text if found else "")
    assert bool(found) == bool(said)
    assert causes.seen({"latency_times": run}, ["clipped"]) is None
