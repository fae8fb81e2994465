"""Scans that a scenario spells out instead of casting them: the test bench.

An open-loop test of perception needs exact readings at exact angles, whatever the robot does.
"""

import math
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

Angle = Annotated[float, Meta(ge=-180, le=180)]
Offset = Annotated[float, Meta(ge=-3600, le=3600)]  # [s]
_TOLERANCE = 1e-6  # [°]; keeps the ends of an interval inside it despite rounding


class Patch(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One range over an interval of angles; from > to wraps around at ±180°."""

    from_deg: Angle  # in the robot's frame, 0 ahead, positive to the left
    to_deg: Angle
    range: float  # [m], or inf, -inf, nan


class BenchScan(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One scan of the bench: a fill, and patches over it (later ones cover earlier ones)."""

    label: str = ""
    tags: tuple[str, ...] = ()
    fill: float = math.inf  # range of beams without a patch [m], or inf, -inf, nan
    patches: Annotated[tuple[Patch, ...], Meta(max_length=1000)] = ()
    repeat: Annotated[int, Meta(ge=1, le=10_000)] = 1  # times in a row
    empty: bool = False  # a scan without beams
    stamp_offset: Offset = 0.0  # added to the header's stamp, as by a driver with a wrong clock [s]


def bench_ranges(scan: BenchScan, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (n,) ranges [m] of a bench scan at these (n,) beam angles [rad]."""
    if scan.empty:
        return np.zeros(0)
    degrees = np.degrees(angles)
    ranges = np.full(len(angles), scan.fill)
    for patch in scan.patches:
        ranges[_within(degrees, patch)] = patch.range
    return ranges


def _within(degrees: NDArray[np.float64], patch: Patch) -> NDArray[np.bool_]:
    width = patch.to_deg - patch.from_deg
    if width < 0:
        width += 360.0
    inside: NDArray[np.bool_] = (
        degrees - patch.from_deg + _TOLERANCE
    ) % 360.0 <= width + 2 * _TOLERANCE
    return inside
