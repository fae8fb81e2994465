"""Exercise 3: a node that finds no goal shows all the same that it heard of a new one."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.goal_seeking import reaching
from grader.exercises.goal_seeking.contract import Quest
from grader.exercises.goal_seeking.reaching import carried_at, reached, require_heard

QUEST = Quest(10.0, 20.0, 5.0, 0.0)
CARRIED = 19.0  # [s]


def recorded(moves: list[float], zeros: list[float]) -> Any:
    """Return a robot that stands 5 m away until it is carried to its goal."""
    times = np.array(sorted(moves + zeros))
    values = np.zeros((len(times), 6))
    values[np.isin(times, moves), 0] = 0.3
    t = np.arange(0.0, 20.0, 0.05)
    x = np.where(t < CARRIED, 0.0, 4.9)
    odom = SimpleNamespace(t=t, x=x, y=0 * t, yaw=0 * t)
    events = (SimpleNamespace(at=CARRIED, teleport=(4.9, 0.0, 0.0)),)
    return SimpleNamespace(
        twists=lambda: SimpleNamespace(t=times, values=values),
        odometry=lambda: odom,
        goals=lambda: SimpleNamespace(t=np.array([10.0]), x=np.array([5.0]), y=np.array([0.0])),
        truth=SimpleNamespace(t=t * 1e9, x=x, y=0 * t, yaw=0 * t),
        scenario=SimpleNamespace(script=events),
        duration_s=20.0,
        name="goal_changes",
        outcome=None,
    )


def drives(begin: float, end: float) -> list[float]:
    return [round(t, 2) for t in np.arange(begin, end, 0.1).tolist()]


def test_who_sets_out_and_stops_where_it_is_carried_has_heard() -> None:
    require_heard(recorded(drives(10.1, 19.0), [19.1]), QUEST)


@pytest.mark.parametrize(
    ("moves", "zeros", "said"),
    [
        ([], [], "does not set out"),
        (drives(12.0, 19.0), [19.1], "does not set out"),
        ([], drives(10.1, 19.0), "does not set out"),
        (drives(10.1, 20.0), [], "did not stop"),
        (drives(10.1, 19.6), [19.6], "did not stop"),
    ],
    ids=["mute", "late", "stands", "drives on", "stops late"],
)
def test_who_does_not_has_not(moves: list[float], zeros: list[float], said: str) -> None:
    with pytest.raises(CheckFailed, match=said):
        require_heard(recorded(moves, zeros), QUEST)


def test_to_be_carried_is_not_to_arrive() -> None:
    recording = recorded(drives(10.1, 19.0), [19.1])
    assert carried_at(recording, QUEST) == CARRIED
    assert not reached(recording, QUEST)
    with pytest.raises(CheckFailed, match="did not reach"):
        reaching.require_reached(recording, QUEST)


@pytest.mark.parametrize("yaw", [0.0, 1.5], ids=["looks at the new goal", "looks away"])
def test_who_drove_to_an_older_goal_is_told_so(yaw: float) -> None:
    recording = recorded([], [])
    old = SimpleNamespace(t=np.array([1.0, 10.0]), x=np.array([0.3, 5.0]), y=np.zeros(2))
    recording.goals = lambda: old
    recording.truth.yaw = recording.truth.yaw + yaw

    with pytest.raises(CheckFailed) as failed:
        reaching.require_reached(recording, QUEST)

    assert "an older one" in failed.value.help
