"""For each exercise that drives: the worlds to try.

========  ========================================================
exercise  worlds
========  ========================================================
1, 4      things that stand, a lidar and its faults
2, 5, 9   the same, and a model that brakes before them
3         goals, odometry and its faults
7         as 1, and a model that never brakes, and emergency stops
========  ========================================================
"""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis.strategies import SearchStrategy

from grader.course.exercises import Exercise
from grader.drive.contracts import contract_of
from grader.drive.mishaps import Contract
from grader.drive.search.worlds import driving_worlds, goal_worlds
from sim.scenario import Model, Scenario

BRAKING = {"scale": 0.5, "offset": -0.35}  # 0 at 0.7 m, 0.5 m/s at 1.7 m: brakes in good time


@dataclass(frozen=True)
class Arena:
    """Where a node of an exercise is looked at, and by what it is judged."""

    worlds: SearchStrategy[Scenario]
    contract: Contract


def arena_of(exercise: Exercise) -> Arena:
    """Return the worlds and the contract of an exercise.

    Raises
    ------
    InputError
        Its nodes do not drive.
    """
    contract = contract_of(exercise)
    return Arena(_WORLDS[exercise.number], contract)


def _with_model(probe: str, **settings: float) -> SearchStrategy[Scenario]:
    return driving_worlds(9.0, Model(probe=probe, settings={**BRAKING, **settings}))


_WORLDS = {
    1: driving_worlds(8.0),
    2: _with_model("echo"),
    3: goal_worlds(),
    4: driving_worlds(9.0),
    5: _with_model("slow", seconds=0.2),
    7: driving_worlds(8.0, supervises=True),
    9: _with_model("slow", seconds=0.02),
}
