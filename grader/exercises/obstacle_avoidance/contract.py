"""The oracle of obstacle_avoidance: what its contract asks for, from the recorded scans."""

from __future__ import annotations

from functools import lru_cache

from grader.checks.ahead import HAIR, Distances, front_distances
from grader.checks.case import Case, answered, exactly
from grader.checks.commands import answers
from grader.checks.contract import RACE, Contract, free_from
from grader.recording import Recording, Scan

STOP_DISTANCE = 0.5  # [m] nearer than this: stop
SLOW_DISTANCE = 1.0  # [m] nearer than this: slow
FULL_SPEED = 0.5  # [m/s]
SLOW_SPEED = 0.15  # [m/s]
CLEARANCE = 0.2  # [m] between the robot's edge and anything else

FREE = free_from(0.55)
CONTRACT = Contract(free=FREE, search_for=8.0, race=RACE)


def cases(recording: Recording) -> list[Case]:
    """Return an occasion for each scan: the speed that its distance asks for."""
    return [
        answered(answer, {"linear.x": exactly(*right_speeds(answer.scan))})
        for answer in answers(recording)
    ]


def right_speeds(scan: Scan) -> frozenset[float]:
    """Return the speeds [m/s] that are right for a scan.

    There are several where the contract leaves room: for beams within 1° of the sector's edge, and
    for distances within 1 mm of a threshold, unless they are exactly on it.
    """
    return _right_speeds(front_distances(scan))


@lru_cache(maxsize=4096)
def _right_speeds(distances: Distances) -> frozenset[float]:
    return frozenset(s for distance in distances for s in _speeds_for(distance))


def _speeds_for(distance: float | None) -> set[float]:
    """Return the forward speeds [m/s] for a distance ahead [m]."""
    if distance is None:
        return {0.0}
    near = any(0.0 < abs(distance - edge) < HAIR for edge in (STOP_DISTANCE, SLOW_DISTANCE))
    seen = (distance - HAIR, distance + HAIR) if near else (distance,)
    return {
        0.0 if d < STOP_DISTANCE else SLOW_SPEED if d < SLOW_DISTANCE else FULL_SPEED for d in seen
    }
