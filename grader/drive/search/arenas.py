"""For each exercise that drives: the worlds to try, and what its contract promises in all of them.

========  ==================================================  ==============================
exercise  worlds                                              stands for ever
========  ==================================================  ==============================
1         things that stand, a lidar and its faults           0.55 m ahead are free
2, 5, 9   the same, and a model that brakes before them       the model says 0.1 m/s or more
3         goals, odometry and its faults                      it never gets to its last goal
4         as 1                                                0.65 m ahead are free
7         as 1, and a model that never brakes, and e-stops    0.55 m ahead, and it is asked to
========  ==================================================  ==============================
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from hypothesis.strategies import SearchStrategy

from grader.checks.ahead import front_distance
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.drive.search.mishaps import Contract, Free, Limits
from grader.drive.search.worlds import driving_worlds, goal_worlds
from grader.errors import InputError
from grader.models.features import scan_features
from grader.models.files import probe
from grader.recording import Scan
from sim.scenario import Model, Scenario

WIDEST = 91.5  # [°] beams near ±90° may count or not
MOVING = 0.1  # [m/s] what asks for less may stand
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
        Its nodes are not searched.
    """
    if exercise.number not in _ARENAS:
        known = ", ".join(map(str, _ARENAS))
        raise InputError(
            f"exercise {exercise.number} has no worlds to search in: its nodes do not drive by "
            f"themselves; expected one of {known}"
        )
    return _ARENAS[exercise.number]


def exercise_for(name: str | None, file: str) -> Exercise:
    """Return the exercise of that name or number; without one, that of the file's name.

    Raises
    ------
    InputError
        There is none of that name, or the file's name is no exercise's.
    """
    if name is not None:
        return find_exercise(name)
    for exercise in all_exercises():
        if file in exercise.files:
            return exercise
    raise InputError(
        f"{file}: its name is that of no exercise's file; expected --exercise N, such as "
        "--exercise 1"
    )


def _ahead(least: float) -> Free:
    def free(scenario: Scenario, scan: Scan) -> bool:
        distance = front_distance(scan, WIDEST)
        return distance is not None and distance >= least

    return free


def _model_says_go(scenario: Scenario, scan: Scan) -> bool:
    row = scan_features(scan)
    if not np.isfinite(row).all():
        return False
    (model,) = scenario.node.models.values()
    return bool(probe(model).predict(row[None])[0] >= MOVING)


def _asked_to_go(scenario: Scenario, scan: Scan) -> bool:
    asked = [stream for stream in scenario.raw if stream.begin <= scan.t < stream.end]
    pressed = [event.e_stop for event in scenario.script if event.at <= scan.t]
    if not asked or not math.isfinite(asked[-1].linear_x) or (pressed and pressed[-1]):
        return False
    return asked[-1].linear_x >= MOVING and _ahead(0.55)(scenario, scan)


def _with_model(probe_name: str, seconds: float | None = None) -> Arena:
    settings = BRAKING if seconds is None else {**BRAKING, "seconds": seconds}
    model = Model(probe=probe_name, settings=dict(settings))
    return Arena(driving_worlds(9.0, model), Contract(Limits(), _model_says_go))


_ARENAS: dict[int, Arena] = {
    1: Arena(driving_worlds(8.0), Contract(Limits(), _ahead(0.55))),
    2: _with_model("echo"),
    3: Arena(goal_worlds(), Contract(Limits(fastest=0.3, turning=1.9))),
    4: Arena(driving_worlds(9.0), Contract(Limits(fastest=0.3), _ahead(0.65), patience=4.0)),
    5: _with_model("slow", 0.2),
    7: Arena(
        driving_worlds(8.0, supervises=True),
        Contract(
            Limits(slowest=-0.5, turning=1.9, rise=0.045),
            _asked_to_go,
            heeds_e_stop=True,
        ),
    ),
    9: _with_model("slow", 0.02),
}
