"""A gap between two commands may be as long as the machine made it, and no longer."""

import contextlib
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.slow_model.words import keeps_period, rare_delay
from grader.recording import Compute, Outcome, Recording

LIVE = SimpleNamespace(lateness=0.06)


@pytest.mark.parametrize(
    ("live", "longest", "count", "forgiven"),
    [
        (LIVE, 0.14, 1, True),
        (LIVE, 0.14, 2, False),
        (LIVE, 0.16, 1, False),
        (None, 0.08, 1, False),
    ],
)
def test_one_gap_in_a_hundred_may_be_linux(
    live: Any, longest: float, count: int, forgiven: bool
) -> None:
    gaps = np.array([0.05] * (100 - count) + [longest] * count)
    assert rare_delay(SimpleNamespace(live=live), gaps, count) == forgiven  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("period", "where", "right"),
    [
        (0.05, None, True),
        (0.1, None, False),  # ten a second: that a thread once waited for 50 ms is no excuse
        (0.05, 0.5, True),  # a long gap, while the thread waited
        (0.05, 0.8, False),  # another one
    ],
)
def test_a_gap_may_be_as_long_as_the_machine_made_it(
    period: float, where: float | None, right: bool
) -> None:
    turns, none = np.arange(20) / 20, np.zeros(20)
    times = np.arange(0.05, 1.0, period)
    if where is not None:
        times = np.concatenate([times, times + 0.95, times + 1.9])
        times = times[~np.isclose(times, where)]
        times = times[~np.isclose(times, where + 1.0) | (where < 0.6)]
    run: Any = SimpleNamespace(live=LIVE, slack=0.11, name="gaps", outcome=Outcome("completed"))
    run.compute = Compute(turns, none, none, np.where(np.isclose(turns, 0.55), 0.05, 0.0))
    run.waited = lambda begin, end: Recording.waited(run, begin, end)
    run.twists, run.duration_s = lambda: SimpleNamespace(t=times), float(times[-1]) + 0.05
    with contextlib.nullcontext() if right else pytest.raises(CheckFailed, match="stumbles"):
        keeps_period([run])
