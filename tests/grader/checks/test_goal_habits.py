"""Exercise 3: what a node makes of its goals, right or wrong."""

import math
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.goal_seeking import habits
from grader.exercises.goal_seeking.contract import TOLERANCE, Frame, Pose, Quest, quests
from grader.exercises.goal_seeking.evidence import require_one_stop
from grader.exercises.goal_seeking.habits import deaf_from, frame_of, tolerance_of, turns_in_garbage
from grader.exercises.goal_seeking.reaching import require_on_the_way
from grader.exercises.goal_seeking.speeds import require_speeds

Rows = list[tuple[float, ...]]
POSES: Rows = [
    (t, x, y, yaw)
    for t, (x, y, yaw) in enumerate(
        [(4.0, 1.0, 2.0), (0.0, 0.0, 1.5), (4.0, 0.0, -3.0), (1.0, -2.0, -1.6), (2.0, 4.0, 2.1)], 1
    )
]
GOALS: Rows = [(0.5, 2.0, 1.0), (1.5, 2.0, 1.0), (3.5, 2.0, 1.0)]
NAN = math.nan


def recorded(
    poses: Rows = POSES,
    goals: Rows = GOALS,
    said: Sequence[tuple[float, ...]] = (),
    end: float = 6.0,
) -> Any:
    """Return a run with (t, x, y, yaw), (t, x, y), and commands (t, linear.x, angular.z)."""
    t, x, y, yaw = np.array(poses, dtype=float).reshape(-1, 4).T
    at, goal_x, goal_y = np.array(goals, dtype=float).reshape(-1, 3).T
    when, speed, turn = np.array(said, dtype=float).reshape(-1, 3).T
    values = np.zeros((len(when), 6))
    values[:, 0], values[:, 5] = speed, turn
    return SimpleNamespace(
        odometry=lambda: SimpleNamespace(t=t, x=x, y=y, yaw=yaw),
        goals=lambda: SimpleNamespace(t=at, x=goal_x, y=goal_y),
        twists=lambda: SimpleNamespace(t=when, values=values, linear_x=speed, angular_z=turn),
        truth=SimpleNamespace(t=t * 1e9, x=x, y=y, yaw=yaw),
        scenario=SimpleNamespace(script=()),
        duration_s=end,
        name="goal_turns",
        outcome=SimpleNamespace(completed=True),
        slack=0.0,
        log=(),
    )


def turned(rate: Callable[[float], float], frame: Frame = Frame.ODOM) -> Any:
    """Return a bench in which a node turns by a rate that it makes of its heading errors."""
    silent = recorded()
    said: Rows = []
    for t, x, y, yaw in POSES:
        goal = [quest for quest in quests(silent, frame) if quest.begin <= t][-1]
        until = min([t + 1.0, *(quest.begin for quest in quests(silent) if quest.begin > t)])
        said.append((until - 0.05, 0.3, rate(goal.heading_error(Pose(t, x, y, yaw)))))
    return recorded(said=said)


@pytest.fixture(autouse=True)
def alive(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("turning", "speeds", "evidence"):
        monkeypatch.setattr(f"grader.exercises.goal_seeking.{module}.require_alive", lambda _: None)


@pytest.mark.parametrize("frame", Frame)
def test_its_turns_tell_what_a_node_takes_a_goal_for(frame: Frame) -> None:
    assert frame_of(turned(lambda error: 2.0 * error, frame)) is frame


@pytest.mark.parametrize(
    "rate", [lambda error: -error, abs, lambda error: 0.0, lambda error: NAN, lambda error: 5e-324]
)
def test_turns_that_lead_nowhere_tell_nothing(rate: Callable[[float], float]) -> None:
    assert frame_of(turned(rate)) is Frame.ODOM


@pytest.mark.parametrize(
    ("rate", "unread"),
    [
        (lambda error: 5e-324 if error > 0 else NAN, True),
        (lambda error: NAN, True),
        (lambda error: error, False),
        (lambda error: -error, False),
        (lambda error: NAN if error > 0 else 1.0, False),  # it knows how to write a number
    ],
)
def test_garbage_is_forgiven_to_who_writes_nothing_else(
    rate: Callable[[float], float], unread: bool
) -> None:
    assert turns_in_garbage(turned(rate)) is unread


@pytest.mark.parametrize(
    ("left", "found"), [(0.8, 0.85), (0.95, 1.0), (0.5, 0.5), (0.3, 0.5), (1.2, 0.5)]
)
def test_it_arrives_where_it_first_stops(left: float, found: float) -> None:
    way = [(1.0, 0.0, 0.0, 0.0), (2.0, 2.0 - left, 0.0, 0.0)]
    stop = [(1.1, 0.3, 0.0), (2.05, 0.0, 0.0)]

    assert tolerance_of(recorded(way, [(0.5, 2.0, 0.0)], stop)) == pytest.approx(found)


def test_who_stops_once_where_it_should_has_no_tolerance_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(habits, "require_one_stop", lambda *_: None)
    way = [(1.0, 0.0, 0.0, 0.0), (2.0, 1.2, 0.0, 0.0)]

    found = tolerance_of(recorded(way, [(0.5, 2.0, 0.0)], [(1.1, 0.3, 0.0), (2.05, 0.0, 0.0)]))

    assert found == TOLERANCE


def test_who_never_answers_a_later_goal_is_deaf_from_its_arrival_on() -> None:
    two = [(1.0, 0.2, 0.0), (3.0, 0.2, 0.0)]
    bench = recorded([(2.0, 1.0, 0.0, 0.0), (4.0, 1.6, 0.0, 0.0)], [(0.5, 2.0, 0.0)])

    assert deaf_from(recorded(POSES, two, [(1.1, 0.0, 0.0)]), bench) == 4.0
    assert deaf_from(recorded(POSES, two, [(1.1, 0.0, 0.0), (5.0, 0.0, 0.0)]), bench) == math.inf
    assert deaf_from(recorded(POSES, two[:1], []), bench) == math.inf


def test_speeds_are_judged_for_the_goal_as_it_is_taken() -> None:
    pose, goal = [(1.0, 0.0, 0.45, 0.0)], [(0.5, 1.0, 0.0)]  # taken for (0, 1), at its left
    say = [(1.5, 0.275, 1.9)]
    slow, fast = [(1.5, 0.1, 1.9)], [(1.5, 0.3, 1.9)]

    for said in (say, slow):
        require_speeds(recorded(pose, goal, said), Frame.SWAPPED, math.inf)
    with pytest.raises(CheckFailed, match=r"wrong speed at 0\.55 m"):
        require_speeds(recorded(pose, goal, fast), Frame.SWAPPED, math.inf)


@pytest.mark.parametrize(("yaw", "heard"), [(1.4, True), (0.0, False)])
def test_who_looks_at_its_goal_at_the_end_is_on_the_way(yaw: float, heard: bool) -> None:
    way = [(1.0, 0.0, 0.0, 0.0), (2.0, 0.0, 1.0, yaw)]
    quest = Quest(0.5, 6.0, 0.0, 5.0)

    if heard:
        require_on_the_way(recorded(way), quest)
        return
    with pytest.raises(CheckFailed, match="not on the way"):
        require_on_the_way(recorded(way), quest)


def test_a_stop_that_turns_is_shown_as_it_is() -> None:
    poses: Rows = [(1.0, 0.0, 0.0, 0.0), (2.0, 1.8, 1.0, 0.0)]
    run = recorded(poses, GOALS[:1], said=[(1.05, 0.3, 0.0), (2.05, 0.0, 0.05)])
    with pytest.raises(CheckFailed) as failed:
        require_one_stop(run, quests(run)[0])
    assert failed.value.actual == "none; at 2.05 s linear.x = 0.00 m/s, angular.z = 0.05 rad/s"
