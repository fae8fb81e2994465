"""Scans that a scenario spells out instead of casting them: the test bench.

An open-loop test of perception needs exact readings at exact angles, whatever the robot does.
"""

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from sim.lidar import LidarProfile

Angle = Annotated[float, Meta(ge=-180, le=180)]
Turn = Annotated[int, Meta(ge=-180, le=180)]
Offset = Annotated[float, Meta(ge=-1.7e9, le=3600)]  # [s] back to the clock's zero at most
EXACT = (0.5, 1.0)  # [m] thresholds of exercises: sent as they are ...
NEAR = 0.008  # [m] ... and what else is to be seen, this much to either side
BEYOND = 0.15  # share by which the other beams of a fill may reach beyond it ...
AT_FILL = 1 / 3  # ... that are not at it
ROOM = 0.05  # [m] a jittered reading stays away from the lidar's limits
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
    # Another seed turns the patches together by whole degrees between these two, which leave what
    # is right for the scan as it is.
    turn_deg: tuple[Turn, Turn] = (0, 0)


def varied(
    bench: Sequence[BenchScan], any_order: bool, rng: np.random.Generator
) -> tuple[BenchScan, ...]:
    """Return the bench as another seed has it: turned, and in its own order.

    A table of the public scans then knows neither what comes when, nor where things are.
    """
    order = rng.permutation(len(bench)) if any_order else range(len(bench))
    return tuple(_turned(bench[i], rng) for i in order)


def _turned(scan: BenchScan, rng: np.random.Generator) -> BenchScan:
    low, high = scan.turn_deg
    if not (angle := int(rng.integers(low, high + 1))):
        return scan
    patches = tuple(
        msgspec.structs.replace(
            patch, from_deg=_wrapped(patch.from_deg + angle), to_deg=_wrapped(patch.to_deg + angle)
        )
        for patch in scan.patches
    )
    label = f"{scan.label}, turned {abs(angle)}° to the {'left' if angle > 0 else 'right'}"
    return msgspec.structs.replace(scan, label=label, patches=patches)


def _wrapped(degrees: float) -> float:
    return (degrees + 180) % 360 - 180


def bench_ranges(
    scan: BenchScan,
    profile: LidarProfile,
    rng: np.random.Generator | None = None,
    turned: float = 0.0,
) -> NDArray[np.float64]:
    """Return the (n,) ranges [m] of a bench scan at the beams of a lidar.

    Parameters
    ----------
    rng
        Draws a jitter: every finite reading moves a little, and background also reaches beyond its
        fill. No two students see the same scan, and what is right for it stays the same kind of
        thing: sectors, thresholds sent exactly, and readings that are no measurement don't move.
    turned
        How far the lidar's mount is turned to the left [rad].
    """
    if scan.empty:
        return np.zeros(0)
    degrees = np.degrees(profile.angles + turned)
    ranges = np.full(len(degrees), scan.fill)
    background = np.ones(len(degrees), bool)
    for patch in scan.patches:
        inside = _within(degrees, patch)
        ranges[inside] = patch.range
        background[inside] = False
    return ranges if rng is None else _jittered(ranges, background, profile, rng)


def _jittered(
    ranges: NDArray[np.float64],
    background: NDArray[np.bool_],
    profile: LidarProfile,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    low, high = profile.range_min + ROOM, profile.range_max - ROOM
    aside = rng.uniform(-NEAR, NEAR, len(ranges)) * ~np.isin(ranges, EXACT)
    beyond = rng.uniform(0.0, BEYOND, len(ranges)) * (rng.random(len(ranges)) > AT_FILL)
    moved = np.where(background, ranges * (1.0 + beyond), ranges) + aside
    measured = (ranges >= low) & (ranges <= high)  # NaN is not, nor is inf
    return np.where(measured, np.minimum(moved, high), ranges)


def _within(degrees: NDArray[np.float64], patch: Patch) -> NDArray[np.bool_]:
    width = patch.to_deg - patch.from_deg
    if width < 0:
        width += 360.0
    inside: NDArray[np.bool_] = (
        degrees - patch.from_deg + _TOLERANCE
    ) % 360.0 <= width + 2 * _TOLERANCE
    return inside
