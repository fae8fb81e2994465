"""Casting a lidar's beams against line segments: an angular sweep in numpy.

Instead of testing each beam against every segment, each segment is tested only against the beams
within the angle that it covers. Along a segment the inverse range is linear in the beam's direction
(cos θ, sin θ), so a scan is a few array operations and one `np.maximum.at`.

Only faces toward the sensor are cast: a solid's outline is wound so that its outside is visible,
and a wall is listed in both directions. A sensor inside a solid therefore sees out of it. A coarse
grid, filled as the robot reaches its cells, holds the faces that are visible from each cell.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sim.layout import Floats, Layout

Indices = NDArray[np.intp]
Complexes = NDArray[np.complex128]  # points and directions of the plane as x + iy
Ends = Complexes  # (2, n): first and second ends of n faces

CELL = 0.25  # side of a cell of that grid [m]
_EDGE_ON = 1e-7  # a face is invisible, seen edge-on, below this length x distance [m²]
_CORNER = 1e-11  # [beams] added to both ends of a face: no beam slips through a corner
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
        [m]; anything farther is not seen.
    """

    def __init__(
        self, segments: Floats, *, beams: int, per_turn: int, angle_min: float, range_max: float
    ) -> None:
        self._ends = _complex(segments)
        self._beams, self._angle_min, self._range_max = beams, angle_min, range_max
        self._nothing = np.full(per_turn, _FAR)
        angles = np.arange(per_turn) * (math.tau / per_turn)
        self._mirrored = np.cos(angles) - 1j * np.sin(angles)  # conjugate directions of the beams
        self._per_radian = per_turn / math.tau
        # One turn is added to all beam numbers: they are positive, so truncating is flooring.
        self._reach = np.array([[per_turn - _CORNER], [per_turn + _CORNER]])
        self._lap = np.tile(np.arange(per_turn), 4)  # beam numbers, modulo a turn
        self._count = np.arange(4 * per_turn)
        self._cells: dict[tuple[int, int], Ends] = {}

    def cast(self, x: float, y: float, yaw: float, moving: Floats | None = None) -> Floats:
        """Return the (beams,) exact ranges [m] from a pose [m, m, rad]; inf: nothing in range.

        `moving` holds (m, 2, 2) more faces, for this scan only.
        """
        ends = self._visible(x, y)
        if moving is not None:
            ends = np.concatenate((ends, _complex(moving)), axis=1)
        first_beam = yaw + self._angle_min
        turn = complex(math.cos(first_beam), -math.sin(first_beam))
        inverse = self._nothing.copy()
        self._sweep(ends - complex(x, y), turn, inverse)
        ranges: Floats = 1.0 / inverse[: self._beams]
        np.putmask(ranges, ranges > self._range_max, math.inf)
        return ranges

    def _sweep(self, ends: Ends, turn: complex, inverse: Floats) -> None:
        """Raise `inverse` (per_turn,) to the inverse ranges of faces relative to the sensor.

        `turn` turns the first beam onto the x axis. With a and b a face's ends, conj(a) b is
        their dot product + i times their cross product, and its argument the angle between them.
        """
        begin, end = ends
        product = begin.conj()
        product *= end
        front = (product.imag > _EDGE_ON).nonzero()[0]
        if not len(front):
            return
        if len(front) < len(begin):
            begin, end, product = begin.take(front), end.take(front), product.take(front)
        slope = end - begin
        slope *= turn
        slope /= product.imag
        which, beam = self._pairs(begin * turn, product)
        candidates = slope.take(which)
        candidates *= self._mirrored.take(beam)
        np.maximum.at(inverse, beam, candidates.imag)

    def _pairs(self, begin: Complexes, product: Complexes) -> tuple[Indices, Indices]:
        """Return face and beam of every pair to test: the beams within each face's angle."""
        limits = np.empty((2, len(begin)))
        np.arctan2(begin.imag, begin.real, out=limits[0])
        np.arctan2(product.imag, product.real, out=limits[1])
        limits[1] += limits[0]
        limits *= self._per_radian
        limits += self._reach
        before, last = limits.astype(np.intp)  # the beams of a face are before + 1 … last
        count = last - before
        ends = count.cumsum()
        pairs = self._numbers(int(ends[-1]) + 1)
        last -= ends
        beam = last.repeat(count)
        beam += pairs[1:]
        return self._numbers(len(count)).repeat(count), self._lap.take(beam)

    def _numbers(self, count: int) -> Indices:
        if count > len(self._count):
            self._count = np.arange(2 * count)
        return self._count[:count]

    def _visible(self, x: float, y: float) -> Ends:
        """Return the (2, n) ends of the faces that are visible from the cell of (x, y)."""
        cell = (math.floor(x / CELL), math.floor(y / CELL))
        ends = self._cells.get(cell)
        if ends is None:
            ends = self._cells[cell] = self._visible_from(cell)
        return ends

    def _visible_from(self, cell: tuple[int, int]) -> Ends:
        middle = complex(cell[0] + 0.5, cell[1] + 0.5) * CELL
        reach = CELL * math.sqrt(0.5) * 1.001  # from the middle to the cell's corners
        begin, along = self._ends[0] - middle, self._ends[1] - self._ends[0]
        length = np.abs(along)
        product = begin.conj() * along
        nearest = np.clip(-product.real / length**2, 0.0, 1.0)
        in_range = np.abs(begin + nearest * along) < self._range_max + reach
        in_front = product.imag / length > -reach
        return np.ascontiguousarray(self._ends[:, in_range & in_front])


def _complex(segments: Floats) -> Ends:
    """Return the (2, n) ends x + iy of (n, 2, 2) segments."""
    ends: Ends = (segments[..., 0] + 1j * segments[..., 1]).T
    return ends
