"""For each exercise that drives: the worlds to try.

========  ========================================================
exercise  worlds
========  ========================================================
1, 4      things that stand, a lidar and its faults
2, 5, 9   the same, and a model that brakes before them
8         the same, in a pickle or in ONNX
3         goals, odometry and its faults
7         as 1, and a model that never brakes, and emergency stops
========  ========================================================
"""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from grader.course.exercises import Exercise
from grader.drive.contracts import contract_of
from grader.drive.mishaps import Contract
from grader.drive.search.worlds import driving_worlds, goal_worlds
from sim.scenario import Model, NodeSpec, Scenario

PICKLE, ONNX = "velocity_model.pkl", "policy.onnx"
BRAKING = {"scale": 0.5, "offset": -0.35}  # 0 at 0.7 m, 0.5 m/s at 1.7 m: brakes in good time


@dataclass(frozen=True)
class Arena:
    """Where a node of an exercise is looked at, and by what it is judged."""

    worlds: SearchStrategy[Scenario]
    contract: Contract


def arena_of(exercise: Exercise, *, field: bool = False) -> Arena:
    """Return the worlds and the contract of an exercise.

    `field`: also what only nodes with the badge field-ready have to cope with.

    Raises
    ------
    InputError
        Its nodes do not drive.
    """
    contract = contract_of(exercise)
    return Arena(_worlds(exercise.number, field=field), contract)


def _worlds(number: int, *, field: bool) -> SearchStrategy[Scenario]:
    if number == 3:
        return goal_worlds(field=field)
    if number == 7:
        return driving_worlds(8.0, supervises=True, field=field)
    nodes = _NODES.get(number, (NodeSpec(),))
    return driving_worlds(8.0 if number == 1 else 9.0, nodes=st.sampled_from(nodes), field=field)


def _braking(probe: str, **settings: float) -> NodeSpec:
    return NodeSpec(models={PICKLE: Model(probe=probe, settings={**BRAKING, **settings})})


_LINEAR = Model(
    probe="linear",
    settings={"weights": (BRAKING["scale"], 0.0, 0.0, 0.0, 0.0), "offset": BRAKING["offset"]},
)
_NODES = {
    2: (_braking("echo"),),
    5: (_braking("slow", seconds=0.2),),
    8: (
        NodeSpec(models={PICKLE: _LINEAR}),
        NodeSpec(parameters={"model_path": ONNX}, models={ONNX: _LINEAR}),
    ),
    9: (_braking("slow", seconds=0.02),),
}
