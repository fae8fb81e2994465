"""The oracle of obstacle_avoidance: what its contract asks for, from the recorded scans."""

from __future__ import annotations

import math
from functools import lru_cache

from grader.checks.ahead import FRONT_HALF_ANGLE, HAIR, front_distance
from grader.checks.case import Case, exactly
from grader.checks.commands import answers
from grader.checks.contract import Contract, Survived, free_from
from grader.recording import Recording, Scan

STOP_DISTANCE = 0.5  # [m] nearer than this: stop
SLOW_DISTANCE = 1.0  # [m] nearer than this: slow
FULL_SPEED = 0.5  # [m/s]
SLOW_SPEED = 0.15  # [m/s]
CLEARANCE = 0.2  # [m] between the robot's edge and anything else
SPEEDS = (0.0, SLOW_SPEED, FULL_SPEED)  # [m/s]
EDGE = 1.0  # [°] beams this near to the sector's edge may or may not count

CONTRACT = Contract(
    free=free_from(0.55),
    search_for=8.0,
    delayed_in=("avoid_wall", "avoid_cart", "avoid_corridor", "avoid_store"),
    survives=Survived(sensors=300, commands=300),
)


def cases(recording: Recording) -> list[Case]:
    """Return an occasion for each scan: the speed that its distance asks for."""
    return [
        Case(
            at=answer.scan.t,
            what=answer.what,
            tags=frozenset(answer.tags),
            allowed={"linear.x": exactly(*right_speeds(answer.scan))},
            said=answer.said("linear.x"),
            count=answer.count,
        )
        for answer in answers(recording)
    ]


def speed_for(distance: float | None) -> float:
    """Return the forward speed [m/s] for a distance ahead [m]."""
    if distance is None or distance < STOP_DISTANCE:
        return 0.0
    return SLOW_SPEED if distance < SLOW_DISTANCE else FULL_SPEED


@lru_cache(maxsize=4096)
def right_speeds(scan: Scan) -> frozenset[float]:
    """Return the speeds [m/s] that are right for a scan.

    There are several where the contract leaves room: for beams within 1° of the sector's edge, and
    for distances within 1 mm of a threshold, unless they are exactly on it.
    """
    speeds: set[float] = set()
    for half_angle in (FRONT_HALF_ANGLE - EDGE, FRONT_HALF_ANGLE + EDGE):
        distance = front_distance(scan, half_angle)
        speeds.add(speed_for(distance))
        if distance is not None and math.isfinite(distance) and _near_a_threshold(distance):
            speeds |= {speed_for(distance - HAIR), speed_for(distance + HAIR)}
    return frozenset(speeds)


def is_free(scan: Scan) -> bool:
    """Return whether the robot has to drive, seeing this."""
    return 0.0 not in right_speeds(scan)


def _near_a_threshold(distance: float) -> bool:
    gaps = (abs(distance - threshold) for threshold in (STOP_DISTANCE, SLOW_DISTANCE))
    return any(0.0 < gap < HAIR for gap in gaps)
