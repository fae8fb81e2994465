"""The distance from the robot's edge to the nearest obstacle, for many poses at once."""

import numpy as np
from numpy.typing import NDArray

from sim.layout import Floats, Layout

FARTHEST = 10.0  # clearance is capped here [m]
_AT_ONCE = 32_768  # pairs of point and segment in one chunk, so that it stays in the cache


def clearance(layout: Layout, seconds: Floats, points: Floats, radius: float) -> Floats:
    """Return the (n,) clearances [m], 0 – `FARTHEST`, of a robot at (n, 2) points.

    `seconds` holds the (n,) scenario times [s] at which it is there, because carts move.
    """
    nearest = np.full(len(points), FARTHEST + radius)
    segments = layout.segments()
    if len(segments):
        nearest = np.minimum(nearest, _distances(points, segments))
    for cart in layout.carts:
        corners = cart.corners(seconds)
        for side in range(4):
            ends = corners[:, [side, (side + 1) % 4]]
            nearest = np.minimum(nearest, _distance(points, ends[:, 0], ends[:, 1]))
    return np.maximum(nearest - radius, 0.0)


def is_inside(layout: Layout, point: tuple[float, float]) -> bool:
    """Say whether a point [m] lies inside a solid or a cart as it stands at time 0."""
    carts = (cart.corners(np.zeros(1))[0] for cart in layout.carts)
    return any(_contains(polygon, point) for polygon in (*layout.solids, *carts))


def _contains(polygon: Floats, point: tuple[float, float]) -> bool:
    (x, y), corners = point, polygon.tolist()
    return all(
        (next_x - at_x) * (y - at_y) - (next_y - at_y) * (x - at_x) >= 0.0
        for (at_x, at_y), (next_x, next_y) in zip(corners, corners[1:] + corners[:1], strict=True)
    )


def _distances(points: Floats, segments: Floats) -> Floats:
    """Return the (n,) distances [m] of (n, 2) points to the nearest of (m, 2, 2) segments."""
    at_once = max(_AT_ONCE // len(segments), 1)
    a, b = segments[:, 0], segments[:, 1]
    chunks = (points[i : i + at_once, None] for i in range(0, len(points), at_once))
    return np.concatenate([_distance(chunk, a, b).min(axis=1) for chunk in chunks])


def _distance(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances [m] of points to segments from `a` to `b`; shapes broadcast."""
    dx, dy = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    px, py = points[..., 0] - a[..., 0], points[..., 1] - a[..., 1]
    along: NDArray[np.float64] = (px * dx + py * dy) / (dx * dx + dy * dy)
    np.clip(along, 0.0, 1.0, out=along)
    px = px - along * dx
    py = py - along * dy
    return np.sqrt(px * px + py * py)
