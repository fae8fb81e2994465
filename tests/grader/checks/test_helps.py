"""What to look at next follows from what came: another unit, sign or reason is named."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.goal_seeking.contract import Quest
from grader.exercises.goal_seeking.reaching import require_reached
from grader.exercises.safety_supervisor import evidence as safety


@pytest.mark.parametrize(
    ("says", "right", "asked"),
    [("e_stop", {"limited"}, True), ("limited", {"limited", "ok"}, False), ("", {"ok"}, False)],
)
def test_the_supervisor_is_asked_about_the_reason_that_it_names_itself(
    monkeypatch: pytest.MonkeyPatch, says: str, right: set[str], asked: bool
) -> None:
    found = [SimpleNamespace(t=1.0, reason="ok"), SimpleNamespace(t=2.0, reason=says)]
    later = SimpleNamespace(t=9.0, reason="bad_command")
    monkeypatch.setattr(safety, "reports", lambda _: [*found, later])
    tick: Any = SimpleNamespace(t=2.0, reasons=right)
    recording: Any = None

    assert (f"Your node says {says} here" in safety._own_reason(recording, tick)) is asked


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
