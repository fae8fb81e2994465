"""What exercise 5's commands may be, and which scans have to be taken."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.exercises.slow_model import contract
from grader.exercises.slow_model.contract import Answer, cases, right_speeds
from grader.recording import Inference

NAN = math.nan


def answer(scan: float, answered: float, speed: float, stamp: float | None = None) -> Answer:
    """An answer about the scan that came at a time [s]; it was stamped then, or at another one."""
    taken: Any = SimpleNamespace(t=scan, stamp=scan if stamp is None else stamp)
    return Answer(taken, scan, answered, speed)


@pytest.mark.parametrize(
    ("said", "t", "right"),
    [
        ([], 1.0, {0.0}),
        ([answer(0.9, 1.1, 0.3)], 1.0, {0.0}),  # not yet answered
        ([answer(0.8, 0.98, 0.3)], 1.0, {0.0, 0.3}),  # control may have been quicker
        ([answer(0.7, 0.9, 0.3)], 1.0, {0.3}),
        ([answer(0.5, 0.7, 0.2), answer(0.7, 0.9, 0.3)], 1.0, {0.3}),
        ([answer(0.5, 0.7, 0.2), answer(0.7, 0.97, 0.3)], 1.0, {0.2, 0.3}),
        ([answer(0.41, 0.6, 0.3)], 1.0, {0.0, 0.3}),  # 0.59 s old: near the limit
        ([answer(0.3, 0.5, 0.3)], 1.0, {0.0}),  # too old
        ([answer(0.3, 0.5, 0.3)], 0.84, {0.3}),
        ([answer(0.7, 0.9, 0.3, stamp=0.3)], 1.0, {0.0}),  # it came late
        ([answer(0.1, 0.9, 0.3, stamp=2.1)], 1.0, {0.3}),  # a clock that is fast
        ([answer(0.5, 0.7, 0.2), answer(0.7, 0.9, NAN)], 1.0, {0.0, 0.2}),  # either is right
        ([answer(0.5, 0.7, 0.2), answer(0.7, 1.1, NAN)], 1.0, {0.2}),  # not yet known
        ([answer(0.5, 0.6, NAN), answer(0.7, 0.9, 0.2)], 1.0, {0.2}),
    ],
)
def test_a_command_is_the_newest_answer_unless_that_is_too_old(
    said: list[Answer], t: float, right: set[float]
) -> None:
    assert right_speeds(said, t, slack=0.0) == right


@pytest.mark.parametrize(
    ("asked", "took", "right"),
    [
        (np.arange(1, 20) / 10, 0.03, True),
        (np.arange(1, 20) / 10 + 0.07, 0.02, False),  # each scan has to wait
        (np.arange(1, 20, 2) / 10, 0.03, False),  # each second one is dropped, without need
        (0.1 + 0.2 * np.arange(10), 0.2, True),
        (0.1 + 0.3 * np.arange(7), 0.2, True),  # a busy flag: the next one when it is idle
        (0.1 + 0.4 * np.arange(5), 0.21, False),
        ([0.1, 0.3], 0.2, False),  # it ends, and does not begin again
    ],
)
def test_a_scan_that_finds_the_model_idle_is_taken_at_once(
    monkeypatch: pytest.MonkeyPatch, asked: Any, took: float, right: bool
) -> None:
    monkeypatch.setattr(contract, "blind", lambda scan: False)
    monkeypatch.setattr(contract, "silence", lambda recording: (math.inf, math.inf))
    monkeypatch.setattr(contract, "answers", lambda recording: ())
    calls = [
        Inference("predict", "m.pkl", round(t * 1e9), round((t + took) * 1e9), 0) for t in asked
    ]
    times = np.arange(1, 20) / 10
    scans = [SimpleNamespace(t=float(t)) for t in times]
    twists = SimpleNamespace(t=np.empty(0), linear_x=np.empty(0))
    run: Any = SimpleNamespace(
        twists=lambda: twists,
        scenario=SimpleNamespace(
            lidar=SimpleNamespace(rate=None), faults=SimpleNamespace(scan_loss=0)
        ),
        inferences=calls,
        scans=lambda: scans,
        slack=0.0,
        duration_s=2.0,
        times=lambda _: times,
    )
    waited = [case.wrong() for case in cases(run) if "idle" in case.tags]
    assert any(waited) is not right
