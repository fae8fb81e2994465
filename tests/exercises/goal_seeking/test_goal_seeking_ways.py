"""Exercise 3: whether a robot got to its goal by itself."""

from types import SimpleNamespace

import numpy as np
import pytest
from goal_runs import recorded

from grader.checks.verdict import CheckFailed
from grader.exercises.goal_seeking.contract import Quest
from grader.exercises.goal_seeking.ways import reaches

GOAL = Quest(0.0, 5.0, 5.0, 0.0)


def test_to_be_carried_is_not_to_arrive() -> None:
    run = recorded([(t, t, 0.0, 0.0) for t in np.arange(0.0, 5.0, 0.05)])
    assert reaches(run, GOAL) == pytest.approx(1.0)
    with pytest.raises(CheckFailed, match="did not reach"):
        reaches(run, GOAL, within=3.0)
    run.scenario.script = (SimpleNamespace(at=4.0, teleport=(4.9, 0.0, 0.0)),)
    with pytest.raises(CheckFailed, match="did not reach"):
        reaches(run, GOAL)
