"""What to look at next follows from what came: another unit, sign or reason is named."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.goal_seeking.contract import Quest
from grader.exercises.goal_seeking.reaching import require_reached
from grader.exercises.latency_monitor.evidence import _slip
from grader.exercises.trend_memory.evidence import _sign


@pytest.mark.parametrize(
    ("value", "wrong_sign"), [(-1.121, True), (1.0, False), (-1.0, False), (0.0, False)]
)
def test_a_closing_speed_with_the_wrong_sign_is_told_so(value: float, wrong_sign: bool) -> None:
    assert bool(_sign(value, 1.1205, 1.1215)) is wrong_sign


@pytest.mark.parametrize(
    ("key", "number", "wanted", "said"),
    [
        ("mean_ms", 9000.0, 9.0, "microseconds"),
        ("mean_ms", 0.009, 9.0, "These are seconds"),
        ("p95_ms", 10.0, 10.45, "Rounded"),
        ("mean_ms", 497.0, 9.0, ""),
        ("mean_ms", 0.0, 9.0, ""),
        ("mean_ms", float("nan"), 9.0, ""),
        ("count", 20.0, 20.5, ""),
    ],
)
def test_a_latency_in_another_unit_is_told_so(
    key: str, number: float, wanted: float, said: str
) -> None:
    told = _slip(key, number, wanted)
    assert said in told
    assert bool(told) is bool(said)


@pytest.mark.parametrize(
    ("yaw", "speed", "said"),
    [(0.0, 0.0, "It looks at the goal and stands"), (0.0, 0.3, "bearing"), (1.5, 0.0, "bearing")],
)
def test_who_stands_in_front_of_its_goal_is_not_told_about_turning(
    yaw: float, speed: float, said: str
) -> None:
    t = np.arange(100) * 0.05
    truth = SimpleNamespace(t=t * 1e9, x=speed * t, y=0 * t, yaw=0 * t + yaw)
    scenario = SimpleNamespace(script=())
    none = SimpleNamespace(t=np.empty(0), x=np.empty(0), y=np.empty(0))
    recording: Any = SimpleNamespace(
        truth=truth,
        scenario=scenario,
        name="goal",
        outcome=None,
        goals=lambda: none,
        duration_s=5.0,
    )

    with pytest.raises(CheckFailed) as failed:
        require_reached(recording, Quest(0.0, 5.0, 5.0, 0.0))

    assert said in failed.value.help
