"""The five features of the model exercises, from a recorded scan: front, left and right of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grader.recording import Scan

FRONT_HALF_ANGLE = 60.0  # [°] the front sector is everything within ±60°
EDGE = 1.0  # [°] beams this near to a sector's edge may count on either side of it
NAMES = ("front minimum", "front mean", "front std", "left minimum", "right minimum")  # all [m]

Floats = NDArray[np.float64]


def features(scan: Scan, half_angle: float = FRONT_HALF_ANGLE) -> Floats | None:
    """Return the (5,) features of a scan [m] as in NAMES; None: a sector has no usable reading."""
    degrees = (np.degrees(scan.angles) + 180.0) % 360.0 - 180.0
    low, high = float(np.float32(scan.range_min)), float(np.float32(scan.range_max))
    ranges = np.where(np.isneginf(scan.ranges), low, np.minimum(scan.ranges, high))
    usable = ranges >= low  # false for NaN
    front, left, right = (
        ranges[usable & inside]
        for inside in (
            np.abs(degrees) <= half_angle,
            degrees > half_angle,
            degrees < -half_angle,
        )
    )
    if not (front.size and left.size and right.size):
        return None
    return np.array([front.min(), front.mean(), front.std(), left.min(), right.min()])


def right_features(scan: Scan) -> tuple[Floats | None, ...]:
    """Return what may be taken for the features: the contract does not split hairs at the edges."""
    angles = (FRONT_HALF_ANGLE, FRONT_HALF_ANGLE - EDGE, FRONT_HALF_ANGLE + EDGE)
    return tuple(features(scan, angle) for angle in angles)


def spell_features(values: Floats) -> str:
    """Return features as a student should see them."""
    return "[" + ", ".join("?" if math.isnan(x) else f"{x:.3f}" for x in values.tolist()) + "] m"
