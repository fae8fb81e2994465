"""What a report may say: the last hundred calls, those that end just then, and real time."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.exercises.latency_monitor.contract import ERROR, OK, STALE, WARN, numbers, right_numbers
from grader.recording import Inference

LIVE = object()
THIRTY_MS = 30_000_000  # [ns]


class Recorded(SimpleNamespace):
    __hash__ = object.__hash__


def recorded(calls: list[tuple[int, int]], live: object = None, slack: float = 0.0) -> Any:
    """Return a recording of calls: when each ended, and how long it took [ns]."""
    inferences = [
        Inference("predict", "model.pkl", end - took, end, took, (0.1,)) for end, took in calls
    ]
    scenario = SimpleNamespace(node=SimpleNamespace(parameters={}))
    return Recorded(live=live, slack=slack, scenario=scenario, inferences=inferences)


def profiled(live: object, slack: float = 0.0) -> Any:
    """Return a hundred calls of 30 ms, one for each scan at 40 Hz: they wait for one another."""
    return recorded([((i + 1) * THIRTY_MS, THIRTY_MS) for i in range(100)], live, slack)


def counts(recording: Any, time: float) -> set[float]:
    return {least["count"] for least, _ in right_numbers(recording, time)}


def test_of_calls_that_end_together_the_first_asked_counts_first() -> None:
    recording = recorded([(2 * 10**9, took) for took in (1_200_000_000, 0, 0)])
    sums = [least["count"] * least["mean_ms"] for least, _ in right_numbers(recording, 2.0)]
    assert sums == pytest.approx([0.0, 1200.0, 1200.0, 1200.0])


def test_a_call_that_ends_near_a_report_may_count_or_not() -> None:
    assert counts(profiled(None), 2.0) == {66}  # 2.0 s / 30 ms
    assert counts(profiled(LIVE), 1.982) == {65, 66}  # 66 ended at 1.980 s, or a moment later
    assert counts(profiled(LIVE, slack=0.04), 2.0) == {65, 66, 67, 68}
    assert counts(profiled(LIVE), 0.0) == {0}


@pytest.mark.parametrize(("live", "longest"), [(None, 30.0), (LIVE, 34.0)])
def test_a_call_takes_up_to_four_milliseconds_longer_in_real_time(
    live: object, longest: float
) -> None:
    for choice in right_numbers(profiled(live), 2.0):
        assert [each["mean_ms"] for each in choice] == pytest.approx([30.0, longest])


@pytest.mark.parametrize(
    ("latencies", "level"),
    [
        ((), STALE),
        ((100.0,) * 100, OK),
        ((99.0,) * 96 + (101.0,) * 4, WARN),
        ((99.0,) * 90 + (101.0,) * 10, ERROR),
    ],
)
def test_the_level_is_about_the_deadline(latencies: tuple[float, ...], level: int) -> None:
    assert numbers(latencies, 100.0)["level"] == level
