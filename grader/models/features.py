"""The five features of a scan that the course's models take, as exercise 2 defines them.

========  ==============================================  =====
column    feature                                         unit
========  ==============================================  =====
0         minimum of the front sector, |θ| ≤ 60°          m
1         mean of the front sector                        m
2         population standard deviation of that sector    m
3         minimum of the left sector, 60° < θ ≤ 180°      m
4         minimum of the right sector, -180° ≤ θ < -60°   m
========  ==============================================  =====

First, +inf and readings above range_max become range_max, -inf becomes range_min, and NaN and
readings below range_min are dropped.
"""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from grader.recording import Scan

Floats = NDArray[np.float64]
Beams = NDArray[np.bool_]
Sectors = tuple[Beams, Beams, Beams]  # front, left and right

NAMES = ("front minimum", "front mean", "front deviation", "left minimum", "right minimum")
FRONT_EDGE = 60.0  # [°]
BACK_EDGE = 180.0  # [°] between left and right
TOLERANCE = 1.0  # [°] beams this close to a sector's edge may count on either side
ROUNDING = 0.01  # [°] error of angles in float32


def features(
    ranges: NDArray[np.floating],
    degrees: Floats,
    range_min: float,
    range_max: float,
    edges: tuple[float, float, float] = (FRONT_EDGE, -FRONT_EDGE, BACK_EDGE),
) -> Floats:
    """Return the (n, 5) features of (n, beams) readings [m]; NaN where a sector is blind.

    Parameters
    ----------
    degrees
        (beams,) angles of the beams [°], 0 ahead, positive to the left.
    edges
        Left and right edge of the front sector, and the edge between left and right [°].
    """
    values = np.asarray(ranges, dtype=float)
    return _of_sectors(values, (range_min, range_max), *_sectors(degrees, edges))


def scan_features(scan: Scan) -> Floats:
    """Return the (5,) features of a scan, exactly as defined; NaN where a sector is blind."""
    edges = (FRONT_EDGE + ROUNDING, -FRONT_EDGE - ROUNDING, BACK_EDGE + ROUNDING)
    found: Floats = _of_scan(scan, edges)[0]
    return found


def possible_features(scan: Scan) -> Floats:
    """Return all (k, 5) features that are accepted for a scan.

    A beam within 1° of a sector's edge may count on either side: for one on the edge, rounding
    decides, and some nodes count beams instead of angles. A row has NaN where a sector is blind.
    Several checks look at the same scan, and a bench repeats it, so the result is cached.
    """
    limits, layout = (scan.range_min, scan.range_max), (scan.angle_min, scan.angle_increment)
    return _possible_features(scan.ranges.tobytes(), limits, layout)


@lru_cache(maxsize=2048)
def _possible_features(
    ranges: bytes, limits: tuple[float, float], layout: tuple[float, float]
) -> Floats:
    values = np.frombuffer(ranges, dtype=np.float32).astype(float)[None, :]
    found = np.unique(
        _of_sectors(values, limits, *_possible_sectors(values.shape[1], *layout)), axis=0
    )
    found.flags.writeable = False
    return found


@lru_cache(maxsize=64)
def _possible_sectors(beams: int, first: float, increment: float) -> Sectors:
    """Return the (k, beams) sectors that are accepted for a lidar, each once."""
    degrees = np.degrees(first + increment * np.arange(beams, dtype=float))
    found = [
        np.concatenate(
            _sectors(degrees, (FRONT_EDGE + left, -FRONT_EDGE - right, BACK_EDGE + back))
        )
        for shift in (ROUNDING, TOLERANCE)
        for left, right in itertools.product((shift, -shift), repeat=2)
        for back in (ROUNDING, -ROUNDING, TOLERANCE, -TOLERANCE)
    ]
    ahead, left, right = np.split(np.unique(found, axis=0), 3, axis=1)
    return ahead, left, right


def _sectors(degrees: Floats, edges: tuple[float, float, float]) -> Sectors:
    """Return which of the (beams,) angles [°] lie in front, left and right sector."""
    left_edge, right_edge, back = edges
    angle = (degrees - back) % 360.0 + back - 360.0  # from back - 360 up to back
    return (angle <= left_edge) & (angle >= right_edge), angle > left_edge, angle < right_edge


def _of_sectors(
    readings: Floats, limits: tuple[float, float], front: Beams, left: Beams, right: Beams
) -> Floats:
    """Return the (n, 5) features of (n or 1, beams) readings in (beams,) or (n, beams) sectors."""
    low, high = (float(np.float32(limit)) for limit in limits)
    usable = (readings >= low) | np.isneginf(readings)  # NaN is in neither
    values = np.clip(np.where(usable, readings, low), low, high)
    ahead = usable & front
    count = ahead.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(ahead, values, 0.0).sum(axis=1) / count
        deviations = np.where(ahead, values - mean[:, None], 0.0)
        std = np.sqrt((deviations**2).sum(axis=1) / count)
    least = [
        np.where(usable & sector, values, np.inf).min(axis=1, initial=np.inf)
        for sector in (front, left, right)
    ]
    found = np.column_stack((least[0], mean, std, least[1], least[2]))
    return np.where(np.isfinite(found), found, np.nan)


def _of_scan(scan: Scan, edges: tuple[float, float, float]) -> Floats:
    degrees = np.degrees(scan.angles)
    return features(scan.ranges[None, :], degrees, scan.range_min, scan.range_max, edges)
