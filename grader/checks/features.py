"""The five features of the model exercises, from a recorded scan: front, left and right of it."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from grader.recording import Scan

FRONT_HALF_ANGLE = 60.0  # [°] the front sector is everything within ±60°
EDGE = 1.0  # [°] beams this near to a sector's edge may count on either side of it
ROUNDING = 0.01  # [°] a beam on an edge falls to one side or the other, each by itself
NAMES = ("front minimum", "front mean", "front std", "left minimum", "right minimum")  # all [m]

Floats = NDArray[np.float64]


def features(
    scan: Scan, left: float = FRONT_HALF_ANGLE, right: float = FRONT_HALF_ANGLE, seam: float = 0.0
) -> Floats | None:
    """Return the (5,) features of a scan [m] as in NAMES; None: a sector has no usable reading.

    Parameters
    ----------
    left, right
        Half angles of the front sector [°].
    seam
        Where the left sector ends behind the robot, beyond 180° [°].
    """
    degrees = (np.degrees(scan.angles) + 180.0 - seam) % 360.0 - 180.0 + seam
    low, high = float(np.float32(scan.range_min)), float(np.float32(scan.range_max))
    ranges = np.where(np.isneginf(scan.ranges), low, np.minimum(scan.ranges, high))
    usable = ranges >= low  # false for NaN
    ahead, on_left, on_right = (
        ranges[usable & inside]
        for inside in (
            (degrees <= left) & (degrees >= -right),
            degrees > left,
            degrees < -right,
        )
    )
    if not (ahead.size and on_left.size and on_right.size):
        return None
    return np.array([ahead.min(), ahead.mean(), ahead.std(), on_left.min(), on_right.min()])


@lru_cache(maxsize=1024)
def right_features(scan: Scan) -> tuple[Floats | None, ...]:
    """Return what may be taken for the features: the contract does not split hairs at the edges."""
    in_and_out = (FRONT_HALF_ANGLE + ROUNDING, FRONT_HALF_ANGLE - ROUNDING)
    edges = [(left, right) for left in in_and_out for right in in_and_out]
    edges += [(FRONT_HALF_ANGLE + edge,) * 2 for edge in (EDGE, -EDGE)]
    return tuple(
        features(scan, left, right, seam) for seam in (ROUNDING, -ROUNDING) for left, right in edges
    )


def spell_features(values: Floats) -> str:
    """Return features as a student should see them."""
    return "[" + ", ".join("?" if math.isnan(x) else f"{x:.3f}" for x in values.tolist()) + "] m"
