"""How near the nearest thing ahead is, as a lidar sees it."""

from __future__ import annotations

from functools import lru_cache
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from grader.recording import Scan

FRONT_HALF_ANGLE = 90.0  # [°]
HALF_ANGLES = (90.0, 88.5, 89.5, 90.5, 91.5)  # [°] beams near the sector's edge may count or not
Distances = tuple[float | None, ...]
HAIR = 0.001  # [m] distances this near to a threshold may fall on either side, unless exact


def front_distance(scan: Scan, half_angle: float = FRONT_HALF_ANGLE) -> float | None:
    """Return the smallest usable distance within ±half_angle [°] of ahead [m]; None: blind."""
    return _distances(scan, (half_angle,))[0]


def front_distances(scan: Scan) -> Distances:
    """Return all distances [m] that a right node may take for the front's; None: blind."""
    return _distances(scan, HALF_ANGLES)


# many checks look at the same scan, as long as there is its recording
_known: WeakKeyDictionary[Scan, dict[tuple[float, ...], Distances]] = WeakKeyDictionary()


def _distances(scan: Scan, half_angles: tuple[float, ...]) -> Distances:
    """Return the smallest usable distance within each half angle [m]; None: blind."""
    known = _known.setdefault(scan, {})
    if half_angles in known:
        return known[half_angles]
    layout = len(scan.ranges), scan.first_angle, scan.angle_increment
    limits = float(scan.range_min), float(scan.range_max)
    readings = np.asarray(scan.ranges, dtype=np.float32).tobytes()
    return known.setdefault(half_angles, _nearest(readings, limits, layout, half_angles))


@lru_cache(maxsize=4096)  # a bench repeats its readings, and every grading has its benches
def _nearest(
    readings: bytes,
    limits: tuple[float, float],
    layout: tuple[int, float, float],
    half_angles: tuple[float, ...],
) -> Distances:
    ranges, (least, most) = np.frombuffer(readings, dtype=np.float32), map(np.float32, limits)
    usable = np.isinf(ranges) | ((ranges >= least) & (ranges <= most))
    ahead = _ahead(*layout, half_angles) & usable
    nearest = np.where(ahead, ranges, np.inf).min(axis=1, initial=np.inf).tolist()
    seen: list[bool] = [bool(row.any()) for row in ahead]
    return tuple(max(0.0, near) if sees else None for near, sees in zip(nearest, seen, strict=True))


@lru_cache(maxsize=256)
def _ahead(
    beams: int, first: float, increment: float, half_angles: tuple[float, ...]
) -> NDArray[np.bool_]:
    """Return which beams of a lidar lie within each ±half angle [°] of ahead, (angles, beams)."""
    degrees = np.degrees(first + increment * np.arange(beams, dtype=float))
    return np.abs((degrees + 180.0) % 360.0 - 180.0) <= np.array(half_angles)[:, None]
