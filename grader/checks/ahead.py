"""How near the nearest thing ahead is, as a lidar sees it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from grader.recording import Scan

FRONT_HALF_ANGLE = 90.0  # [°]
HALF_ANGLES = (90.0, 88.5, 89.5, 90.5, 91.5)  # [°] beams near the sector's edge may count or not
HAIR = 0.001  # [m] distances this near to a threshold may fall on either side, unless exact


@lru_cache(maxsize=4096)  # many checks look at the same scan
def front_distance(scan: Scan, half_angle: float = FRONT_HALF_ANGLE) -> float | None:
    """Return the smallest usable distance within ±half_angle [°] of ahead [m]; None: blind."""
    layout = len(scan.ranges), scan.first_angle, scan.angle_increment
    ranges = scan.ranges[_ahead(*layout, half_angle)].astype(np.float64)
    limits = np.float32(scan.range_min), np.float32(scan.range_max)
    usable = ranges[np.isinf(ranges) | ((ranges >= limits[0]) & (ranges <= limits[1]))]
    return max(0.0, float(usable.min())) if usable.size else None


def front_distances(scan: Scan) -> tuple[float | None, ...]:
    """Return all distances [m] that a right node may take for the front's; None: blind."""
    return tuple(front_distance(scan, half_angle) for half_angle in HALF_ANGLES)


@lru_cache(maxsize=256)
def _ahead(beams: int, first: float, increment: float, half_angle: float) -> NDArray[np.bool_]:
    """Return which beams of a lidar lie within ±half_angle [°] of ahead, (beams,)."""
    degrees = np.degrees(first + increment * np.arange(beams, dtype=float))
    return np.abs((degrees + 180.0) % 360.0 - 180.0) <= half_angle
