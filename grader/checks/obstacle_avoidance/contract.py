"""The oracle of obstacle_avoidance: what its contract asks for, from the recorded scans."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from grader.recording import Scan

STOP_DISTANCE = 0.5  # [m] nearer than this: stop
SLOW_DISTANCE = 1.0  # [m] nearer than this: slow
FULL_SPEED = 0.5  # [m/s]
SLOW_SPEED = 0.15  # [m/s]
FRONT_HALF_ANGLE = 90.0  # [°]
EDGE = 1.0  # [°] beams this near to the sector's edge may or may not count
HAIR = 0.001  # [m] distances this near to a threshold may fall on either side, unless exact


@lru_cache(maxsize=4096)  # many checks look at the same scan
def front_distance(scan: Scan, half_angle: float = FRONT_HALF_ANGLE) -> float | None:
    """Return the smallest usable distance within ±half_angle [°] of ahead [m]; None: blind."""
    layout = len(scan.ranges), scan.angle_min, scan.angle_increment
    ranges = scan.ranges[_ahead(*layout, half_angle)].astype(np.float64)
    limits = np.float32(scan.range_min), np.float32(scan.range_max)
    usable = ranges[np.isinf(ranges) | ((ranges >= limits[0]) & (ranges <= limits[1]))]
    return max(0.0, float(usable.min())) if usable.size else None


@lru_cache(maxsize=256)
def _ahead(beams: int, angle_min: float, increment: float, half_angle: float) -> NDArray[np.bool_]:
    """Return which beams of a lidar lie within ±half_angle [°] of ahead, (beams,)."""
    degrees = np.degrees(angle_min + increment * np.arange(beams, dtype=float))
    return np.abs((degrees + 180.0) % 360.0 - 180.0) <= half_angle


def speed_for(distance: float | None) -> float:
    """Return the forward speed [m/s] for a distance ahead [m]."""
    if distance is None or distance < STOP_DISTANCE:
        return 0.0
    return SLOW_SPEED if distance < SLOW_DISTANCE else FULL_SPEED


@lru_cache(maxsize=4096)
def right_speeds(scan: Scan) -> frozenset[float]:
    """Return the speeds [m/s] that are right for a scan.

    More than one where the contract does not split hairs: beams within 1° of the sector's edge,
    distances within 1 mm of a threshold (the threshold itself excepted).
    """
    speeds: set[float] = set()
    for half_angle in (FRONT_HALF_ANGLE - EDGE, FRONT_HALF_ANGLE + EDGE):
        distance = front_distance(scan, half_angle)
        speeds.add(speed_for(distance))
        if distance is not None and math.isfinite(distance) and _splits_hairs(distance):
            speeds |= {speed_for(distance - HAIR), speed_for(distance + HAIR)}
    return frozenset(speeds)


def _splits_hairs(distance: float) -> bool:
    gaps = (abs(distance - threshold) for threshold in (STOP_DISTANCE, SLOW_DISTANCE))
    return any(0.0 < gap < HAIR for gap in gaps)
