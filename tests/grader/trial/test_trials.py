"""The trials of one grading: how often each of their robots is built."""

from collections import Counter

import pytest

from grader.course.exercises import SOLUTIONS
from grader.course.submission import Submission
from grader.link.hosts import ForkServer
from grader.trial.trials import NodeTrials, trial_seed
from sim import simulation
from sim.robot import Robot
from sim.scenario import load_scenario

CLUTTERED = "avoid_store"  # its seed is chosen among several layouts
REFERENCE = SOLUTIONS / "obstacle_avoidance" / "obstacle_avoidance_agent.py"


@pytest.fixture
def builds(monkeypatch: pytest.MonkeyPatch) -> Counter[tuple[float, float, float]]:
    """Count the robots that simulations put into a world, by their start."""
    counts: Counter[tuple[float, float, float]] = Counter()

    class Counted(Robot):
        def __init__(self, spec, layout, **options) -> None:
            counts[layout.start] += 1
            super().__init__(spec, layout, **options)

    monkeypatch.setattr(simulation, "Robot", Counted)
    return counts


@pytest.mark.parametrize("seed", [None, 7])
def test_a_graded_trial_builds_one_simulation(
    forkserver: ForkServer, builds: Counter[tuple[float, float, float]], seed: int | None
) -> None:
    with NodeTrials(Submission(REFERENCE), forkserver, seed=seed) as trials:
        recording = trials.get(CLUTTERED)

    assert recording.outcome.completed
    assert recording.seed == trial_seed(load_scenario(CLUTTERED), seed)
    assert builds == {recording.layout.start: 1}


def test_choosing_a_seed_builds_none(builds: Counter[tuple[float, float, float]]) -> None:
    assert trial_seed(load_scenario(CLUTTERED), 7) != load_scenario(CLUTTERED).seed
    assert not builds
