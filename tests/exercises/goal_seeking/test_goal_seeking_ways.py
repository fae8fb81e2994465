"""Exercise 3: whether a robot got to its goal by itself, and what to look at if it did not."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from goal_runs import recorded

from grader.checks.verdict import CheckFailed
from grader.exercises.goal_seeking.contract import Quest
from grader.exercises.goal_seeking.ways import path_ratio, reaches

GOAL = Quest(0.0, 5.0, 5.0, 0.0)


def drive(speed: float, yaw: float = 0.0, goals: Any = ()) -> Any:
    run = recorded([(t, speed * t, 0.0, yaw) for t in np.arange(0.0, 5.0, 0.05)], goals)
    run.truth.v = run.truth.v + speed
    return run


@pytest.mark.parametrize(
    ("yaw", "speed", "said"),
    [(0.0, 0.0, "It looks at the goal and stands"), (0.0, 0.3, "bearing"), (1.5, 0.0, "bearing")],
)
def test_a_robot_that_stands_in_front_of_its_goal_hears_nothing_about_turning(
    yaw: float, speed: float, said: str
) -> None:
    with pytest.raises(CheckFailed) as failed:
        reaches(drive(speed, yaw), GOAL)
    assert said in failed.value.help


def test_it_is_said_that_the_robot_is_at_an_older_goal() -> None:
    quest = Quest(1.0, 5.0, 5.0, 0.0)
    with pytest.raises(CheckFailed) as failed:
        reaches(drive(0.0, goals=[(0.5, 0.3, 0.0), (1.0, 5.0, 0.0)]), quest)
    assert "an older one" in failed.value.help


def test_to_be_carried_is_not_to_arrive() -> None:
    run = drive(1.0)
    reaches(run, GOAL)
    assert path_ratio(run, GOAL) == pytest.approx(1.0)
    with pytest.raises(CheckFailed, match="did not reach"):
        reaches(run, GOAL, within=3.0)
    run.scenario.script = (SimpleNamespace(at=4.0, teleport=(4.9, 0.0, 0.0)),)
    with pytest.raises(CheckFailed, match="did not reach"):
        reaches(run, GOAL)
