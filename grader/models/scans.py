"""Scans from seeded worlds, and what is really there.

Observations (`ranges`)
    One row per scan of the default lidar, as it reads: 5 mm of noise, +inf where nothing came back,
    -inf where something nearly touches the robot, one reading in fifty NaN, and now and then a
    whole sector without readings.

Poses
    A hundred in each room: half of them anywhere in it, half near an obstacle, where the speed
    changes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grader.models.features import BACK_EDGE, FRONT_EDGE
from sim.caster import Caster, static_faces
from sim.clearance import is_inside
from sim.faults import measured, speckle
from sim.layout import Layout
from sim.lidar import PROFILES, readings
from sim.placement import build_layout
from sim.scenario import Faults
from sim.world import Clutter, Pillar, Wall, World

Floats = NDArray[np.float64]

PROFILE = PROFILES["default"]
ROWS_PER_ROOM = 100
ROBOT_RADIUS = 0.17  # [m]
NEAR = (0.18, 0.7)  # [m] from a surface, for the poses near something
FAULTS = Faults(range_noise=0.005, beam_dropout=0.01, nan_speckle=0.02)
TOUCHING = 0.2  # [m] closer than this, half of the scans read -inf
BLIND_PART = 0.03  # of the rows have a sector without any reading
SECTORS = ((-FRONT_EDGE, FRONT_EDGE), (FRONT_EDGE, BACK_EDGE), (-BACK_EDGE, -FRONT_EDGE))  # [°]
MARGIN = 2.0  # [°] by which a blind sector is wider on each side


@dataclass(frozen=True, eq=False)
class Scans:
    """Readings of the lidar, and the same without its faults."""

    ranges: NDArray[np.float32]  # (n, 360) [m]
    exact: Floats  # (n, 360) [m]; inf where nothing is
    room: NDArray[np.int64]  # (n,)


def make_scans(rows: int, seed: int, *, blind: bool, plain: bool) -> Scans:
    """Return so many scans; the same seed gives the same poses, whatever the lidar does.

    Parameters
    ----------
    blind
        Some rows have a sector without any reading.
    plain
        Finite numbers only, as no lidar sends them: the exact distances, at most range_max.
    """
    ranges = np.empty((rows, PROFILE.beams), np.float32)
    exact = np.empty((rows, PROFILE.beams))
    room = np.arange(rows) // ROWS_PER_ROOM
    for number in range(int(room[-1]) + 1):
        lidar = np.random.default_rng((seed, number, 1))
        poses = _scans(np.random.default_rng((seed, number)))
        for row, scan in zip(np.flatnonzero(room == number), poses, strict=False):
            exact[row] = scan
            ranges[row] = (
                np.minimum(scan, PROFILE.range_max) if plain else _read(scan, lidar, blind=blind)
            )
    return Scans(ranges, exact, room)


def _read(scan: Floats, rng: np.random.Generator, *, blind: bool) -> NDArray[np.float32]:
    """Return the lidar's readings of exact ranges [m]."""
    read = readings(measured(scan, FAULTS, rng), PROFILE)
    if rng.random() < 0.5:
        read[scan < TOUCHING] = -np.inf
    read = speckle(read, FAULTS, rng)
    if blind and rng.random() < BLIND_PART:
        read[_sector(*SECTORS[rng.integers(len(SECTORS))])] = np.nan
    return read


def _scans(rng: np.random.Generator) -> Iterator[Floats]:
    """Yield exact (360,) ranges [m] from poses in one random world, for ever."""
    layout = build_layout(_world(rng), start=(0.0, 0.0, 0.0), rng=rng)
    faces = static_faces(layout)
    caster = Caster(
        faces,
        beams=PROFILE.beams,
        per_turn=PROFILE.per_turn,
        angle_min=PROFILE.angle_min,
        range_max=PROFILE.range_max,
    )
    near = False
    while True:
        x, y, yaw = _pose_near(faces, rng) if near else _pose_anywhere(rng)
        if _is_outside(layout, x, y):
            continue
        ranges = caster.cast(x, y, yaw)
        if ranges.min() >= ROBOT_RADIUS:
            near = not near
            yield ranges


def _world(rng: np.random.Generator) -> World:
    """Return a walled room with boxes and pillars in it."""
    width, depth = rng.uniform(5.0, 10.0), rng.uniform(4.0, 9.0)  # [m]
    x, y = width / 2, depth / 2
    pillars = tuple(
        Pillar(
            (float(rng.uniform(1.0, x)), float(rng.uniform(-y, y))), float(rng.uniform(0.1, 0.3))
        )
        for _ in range(rng.integers(4))
    )
    count = int(width * depth * rng.uniform(0.08, 0.2))
    return World(
        walls=(Wall(((-x, -y), (x, -y), (x, y), (-x, y)), closed=True),),
        pillars=pillars,
        clutter=(Clutter(((-x, -y), (x, y)), count, (0.15, 0.8)),),
    )


def _pose_anywhere(rng: np.random.Generator) -> tuple[float, float, float]:
    x, y = rng.uniform(-5.0, 5.0), rng.uniform(-4.5, 4.5)
    return float(x), float(y), float(rng.uniform(-math.pi, math.pi))


def _pose_near(faces: Floats, rng: np.random.Generator) -> tuple[float, float, float]:
    """Return a pose near a face, which is roughly ahead."""
    begin, end = faces[rng.integers(len(faces))]
    along = end - begin
    normal = np.array([-along[1], along[0]]) / math.hypot(*along)  # towards the face's visible side
    point = begin + rng.random() * along
    x, y = point + rng.uniform(*NEAR) * normal
    yaw = math.atan2(-normal[1], -normal[0]) + rng.uniform(-0.8, 0.8)
    return float(x), float(y), yaw


def _is_outside(layout: Layout, x: float, y: float) -> bool:
    """Return whether a point lies in a solid, or beyond the room's wall."""
    corners = layout.walls[0]
    low, high = corners.min(axis=0), corners.max(axis=0)
    inside = low[0] < x < high[0] and low[1] < y < high[1]
    return not inside or is_inside(layout, (x, y))


def _sector(begin: float, end: float) -> NDArray[np.bool_]:
    degrees = np.degrees(PROFILE.angles)
    return (degrees >= begin - MARGIN) & (degrees <= end + MARGIN)
