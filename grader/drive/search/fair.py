"""Is a world fair? A right node of the exercise must be able to cope with it."""

import math

import numpy as np

from sim.clearance import clearance, is_inside
from sim.placement import build_layout
from sim.scenario import Scenario

START_ROOM = 0.3  # [m] from the robot's edge to the nearest thing
CREEP = 0.3  # [m/s] the fastest that a model may ask for where scans are lost


def is_fair(scenario: Scenario) -> bool:
    """Say whether the robot starts clear of everything, and is not asked for the impossible."""
    return _starts_clear(scenario) and _can_stop(scenario)


def _starts_clear(scenario: Scenario) -> bool:
    x, y, yaw = scenario.robot.start
    layout = build_layout(scenario.world, start=(x, y, math.radians(yaw)))
    room = clearance(layout, np.zeros(1), np.array([[x, y]]), scenario.robot.radius)[0]
    return bool(room >= START_ROOM) and not is_inside(layout, (x, y))


def _can_stop(scenario: Scenario) -> bool:
    """A supervisor notices half a second late that scans are lost: then 0.5 m/s is too fast.

    From 0.5 m before an obstacle 0.25 m are driven until then, and 0.14 m while braking; the
    robot's radius is 0.17 m.
    """
    faults = scenario.faults
    if not (faults.scan_loss or faults.blackout):
        return True
    return not any(stream.linear_x > CREEP for stream in scenario.raw)
