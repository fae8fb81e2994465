"""What each exercise that drives promises of any drive, and how to tell whose node a file is.

==========  ==============================================  ===================================
exercise    every command                                   the way is free
==========  ==============================================  ===================================
1           0 … 0.5 m/s                                     0.55 m ahead
2, 5, 8, 9  0 … 0.5 m/s                                     the model says 0.1 m/s or more
3           0 … 0.3 m/s, ±1.9 rad/s                         always: it gets to its last goal
4           0 … 0.3 m/s                                     0.65 m ahead
7           ±0.5 m/s, ±1.9 rad/s, rises by 0.045 m/s        0.55 m ahead, and is asked to drive
==========  ==============================================  ===================================
"""

from __future__ import annotations

import math

import numpy as np

from grader.checks.ahead import front_distance
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.drive.mishaps import Contract, Free, Limits
from grader.errors import InputError
from grader.models.features import scan_features
from grader.models.files import probe
from grader.recording import Scan
from sim.scenario import Scenario

SECTORS = (88.5, 91.5)  # [°] to either side: beams near ±90° may count or not
MOVING = 0.1  # [m/s] what asks for less may stand


def contract_of(exercise: Exercise) -> Contract:
    """Return what an exercise promises.

    Raises
    ------
    InputError
        Its nodes do not drive.
    """
    if exercise.number not in _CONTRACTS:
        known = ", ".join(map(str, _CONTRACTS))
        raise InputError(
            f"exercise {exercise.number}: its nodes do not drive by themselves; expected one of "
            f"{known}"
        )
    return _CONTRACTS[exercise.number]


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
        seen = [front_distance(scan, half_angle) for half_angle in SECTORS]
        return all(distance is not None and distance >= least for distance in seen)

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


_BY_MODEL = Contract(Limits(), _model_says_go)
_CONTRACTS = {
    1: Contract(Limits(), _ahead(0.55)),
    2: _BY_MODEL,
    3: Contract(Limits(fastest=0.3, turning=1.9)),
    4: Contract(Limits(fastest=0.3), _ahead(0.65), patience=4.0),
    5: _BY_MODEL,
    7: Contract(Limits(slowest=-0.5, turning=1.9, rise=0.045), _asked_to_go, heeds_e_stop=True),
    8: _BY_MODEL,
    9: _BY_MODEL,
}
