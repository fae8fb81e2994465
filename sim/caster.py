"""Casting a lidar's beams against line segments: an angular sweep in numpy.

Instead of asking for every beam which segments it meets, every segment is tested only against the
beams inside the angle that it covers. Over such a segment the inverse range is linear in the beam's
direction (cos θ, sin θ), so a scan is a few array operations and one `np.maximum.at`.

Only faces that look at the sensor are cast: a solid's outline is wound so that its outside counts,
and a wall is listed in both directions. A sensor inside a solid therefore sees out of it. A coarse
grid remembers, cell by cell as the robot gets there, which faces can be seen from a cell at all.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sim.layout import Floats, Layout

CELL = 0.25  # of the grid of visible faces [m]
_EDGE_ON = 1e-7  # faces seen under less than this (length x distance [m²]) are lines: invisible
_CORNER = 1e-11  # beams that a face reaches beyond its ends, so that no beam slips through a corner
_FAR = 1e-9  # inverse range of a beam that meets nothing [1/m]


def static_faces(layout: Layout) -> Floats:
    """Return the (n, 2, 2) faces of walls and solids [m], wound for `Caster`."""
    parts = [faces(solid) for solid in layout.solids]
    for wall in layout.walls:
        one_side = np.stack((wall[:-1], wall[1:]), 1)
        parts += [one_side, one_side[:, ::-1]]
    return np.concatenate(parts) if parts else np.zeros((0, 2, 2))


def faces(polygon: Floats) -> Floats:
    """Return the (n, 2, 2) outward faces of a counter-clockwise (n, 2) polygon [m]."""
    return np.stack((np.roll(polygon, -1, axis=0), polygon), 1)


class Caster:
    """Casts the beams of one lidar in one world.

    Parameters
    ----------
    segments
        (n, 2, 2) faces [m] as `static_faces` gives them: only the side from which the second end
        lies to the left of the first is visible.
    beams, per_turn
        Beams of a scan, and beams that a full turn would have (≥ beams).
    angle_min
        Angle of the first beam in the sensor's frame [rad]; the others follow to the left.
    range_max
        [m]; whatever is farther is not seen.
    """

    def __init__(
        self, segments: Floats, *, beams: int, per_turn: int, angle_min: float, range_max: float
    ) -> None:
        self._a, self._b = segments[:, 0], segments[:, 1]
        self._beams, self._turn = beams, per_turn
        self._angle_min, self._range_max = angle_min, range_max
        self._per_radian = per_turn / math.tau
        directions = np.arange(per_turn) * (math.tau / per_turn)
        self._cos, self._sin = np.cos(directions), np.sin(directions)
        self._lap = np.tile(np.arange(per_turn), 4)  # beam numbers, modulo a turn
        self._count = np.arange(4 * per_turn)
        self._cells: dict[tuple[int, int], Floats] = {}

    def cast(self, x: float, y: float, yaw: float, moving: Floats | None = None) -> Floats:
        """Return the (beams,) exact ranges [m] from a pose [m, m, rad]; inf: nothing in range.

        `moving` are (m, 2, 2) further faces of this scan only.
        """
        ends = self._visible(x, y)
        if moving is not None:
            ends = np.concatenate((ends, moving.transpose(2, 1, 0)), axis=2)
        inverse = np.full(self._turn, _FAR)
        self._sweep(ends, x, y, yaw + self._angle_min, inverse)
        ranges = 1.0 / inverse[: self._beams]
        ranges[ranges > self._range_max] = math.inf
        return ranges

    def _sweep(self, ends: Floats, x: float, y: float, yaw: float, inverse: Floats) -> None:
        """Raise `inverse` (per_turn,) to the inverse ranges of these (2, 2, n) ends [xy, ab, n]."""
        ax, bx = ends[0] - x
        ay, by = ends[1] - y
        cross = ax * by
        cross -= ay * bx
        front = (cross > _EDGE_ON).nonzero()[0]
        if not len(front):
            return
        cross, ax, ay = cross.take(front), ax.take(front), ay.take(front)
        bx, by = bx.take(front), by.take(front)
        c, s = math.cos(yaw), math.sin(yaw)  # the first beam's direction is the x axis from here on
        first = np.arctan2(ay * c - ax * s, ax * c + ay * s)
        last = np.arctan2(cross, ax * bx + ay * by)
        bx -= ax
        by -= ay
        bx /= cross
        by /= cross
        which, beam = self._pairs(first, last)
        candidates = (by * c - bx * s).take(which)
        candidates *= self._cos.take(beam)
        rest = (by * s + bx * c).take(which)
        rest *= self._sin.take(beam)
        candidates -= rest
        np.maximum.at(inverse, beam, candidates)

    def _pairs(self, first: Floats, span: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return face and beam of every pair to test, for faces from angle `first` over `span`."""
        first *= self._per_radian
        span *= self._per_radian
        span += first
        span += _CORNER
        first -= _CORNER
        begin = np.ceil(first)
        count = (np.floor(span) - begin + 1.0).astype(np.intp)
        ends = count.cumsum()
        which = np.arange(len(count)).repeat(count)
        shift = begin.astype(np.intp) - ends + count + self._turn
        beam = shift.take(which)
        beam += self._numbers(int(ends[-1]))
        return which, self._lap.take(beam)

    def _numbers(self, count: int) -> NDArray[np.intp]:
        if count > len(self._count):
            self._count = np.arange(2 * count)
        return self._count[:count]

    def _visible(self, x: float, y: float) -> Floats:
        """Return the (2, 2, n) ends [xy, ab, n] of the faces visible from around (x, y)."""
        cell = (math.floor(x / CELL), math.floor(y / CELL))
        ends = self._cells.get(cell)
        if ends is None:
            ends = self._cells[cell] = self._visible_from(cell)
        return ends

    def _visible_from(self, cell: tuple[int, int]) -> Floats:
        center = (np.array(cell) + 0.5) * CELL
        reach = CELL * math.sqrt(0.5) * 1.001  # from the centre to the cell's corners
        a, along = self._a - center, self._b - self._a
        length = np.hypot(*along.T)
        nearest = np.clip(-(a * along).sum(1) / length**2, 0.0, 1.0)
        distance = np.hypot(*(a + nearest[:, None] * along).T)
        height = (a[:, 0] * along[:, 1] - a[:, 1] * along[:, 0]) / length
        seen = (distance < self._range_max + reach) & (height > -reach)
        return np.ascontiguousarray(np.stack((self._a[seen], self._b[seen])).transpose(2, 0, 1))
