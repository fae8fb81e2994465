"""The geometry of one run: where walls, solids and carts are, and where the robot starts.

A `Layout` is a world file whose clutter the seed has placed and which the scenario has mirrored and
rotated. Physics, lidar, checks and replay all read it.
"""

import bisect
import json
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pose = tuple[float, float, float]  # x [m], y [m], yaw [rad]


def in_frame(frame: Pose, local: Pose) -> Pose:
    """Return the pose [m, m, rad] of what is at `local` in the frame at `frame`."""
    x, y, yaw = frame
    dx, dy, turn = local
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + cos * dx - sin * dy, y + sin * dx + cos * dy, yaw + turn


@dataclass(frozen=True, eq=False)
class Cart:
    """A solid box that moves along waypoints; it rests before the first and after the last."""

    polygon: Floats  # (4, 2) counter-clockwise corners around the cart's own centre, x ahead [m]
    path: Floats  # (k, 3) rows of time [s], x [m], y [m]; times increase
    loop: bool = False  # start over at the last waypoint, which is where the first one is

    def poses(self, seconds: Floats) -> Floats:
        """Return the (n, 3) poses x [m], y [m], yaw [rad] at these (n,) scenario times [s]."""
        times, leg = self._locate(seconds)
        t, x, y = self.path.T
        return np.column_stack((np.interp(times, t, x), np.interp(times, t, y), self.yaws[leg]))

    def pose(self, seconds: float) -> Pose:
        """Return x [m], y [m] and yaw [rad] at one scenario time [s]."""
        times, xs, ys, yaws = self._lists
        t = seconds
        if self.loop and len(times) > 1 and t > times[0]:
            t = times[0] + (t - times[0]) % (times[-1] - times[0])
        i = min(max(bisect.bisect_right(times, t) - 1, 0), len(times) - 1)
        yaw = yaws[min(i, len(yaws) - 1)]
        if t <= times[0] or i == len(times) - 1:
            return xs[i], ys[i], yaw
        since, lasts = t - times[i], times[i + 1] - times[i]
        dx, dy = (xs[i + 1] - xs[i]) / lasts, (ys[i + 1] - ys[i]) / lasts
        return dx * since + xs[i], dy * since + ys[i], yaw

    def corners(self, seconds: Floats) -> Floats:
        """Return the (n, 4, 2) corners in the world [m] at these (n,) scenario times [s]."""
        poses = self.poses(seconds)
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        turn = np.stack((np.stack((c, s), -1), np.stack((-s, c), -1)), 1)  # (n, 2, 2)
        corners: Floats = self.polygon @ turn + poses[:, None, :2]
        return corners

    @cached_property
    def _lists(self) -> tuple[list[float], ...]:
        """Times, x, y and yaws as lists: for a single pose ten times faster than arrays."""
        t, x, y = self.path.T.tolist()
        return t, x, y, self.yaws.tolist()

    @cached_property
    def yaws(self) -> Floats:
        """(max(k - 1, 1),) direction of each leg [rad]; a halt keeps the previous direction."""
        steps = np.diff(self.path[:, 1:], axis=0)
        yaws = np.zeros(max(len(steps), 1))
        moving = np.flatnonzero(np.any(steps != 0, axis=1))
        for leg in range(len(steps)) if len(moving) else ():
            before = moving[moving <= leg]
            dx, dy = steps[before[-1] if len(before) else moving[0]]
            yaws[leg] = math.atan2(dy, dx)
        return yaws

    def _locate(self, seconds: Floats) -> tuple[Floats, NDArray[np.intp]]:
        t = self.path[:, 0]
        times = np.asarray(seconds, float)
        if self.loop and len(t) > 1:
            lap = np.maximum(times - t[0], 0.0) % (t[-1] - t[0])
            times = np.where(times > t[0], t[0] + lap, times)
        leg = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(self.yaws) - 1)
        return times, leg


@dataclass(frozen=True, eq=False)
class Layout:
    """Everything the robot can run into, and where it starts [m, rad]."""

    walls: tuple[Floats, ...]  # (n, 2) polylines, thin and two-sided; closed: first point repeated
    solids: tuple[Floats, ...]  # (n, 2) convex polygons, counter-clockwise
    carts: tuple[Cart, ...]
    start: Pose  # of the robot

    def segments(self) -> Floats:
        """Return the (n, 2, 2) static segments [m]: those of the walls, then of the solids."""
        parts = [np.stack((w[:-1], w[1:]), 1) for w in self.walls]
        parts += [np.stack((s, np.roll(s, -1, axis=0)), 1) for s in self.solids]
        return np.concatenate(parts) if parts else np.zeros((0, 2, 2))


def layout_to_json(layout: Layout) -> str:
    """Return the layout as JSON; `layout_from_json` restores it to the last bit."""
    carts = [
        {"polygon": c.polygon.tolist(), "path": c.path.tolist(), "loop": c.loop}
        for c in layout.carts
    ]
    return json.dumps(
        {
            "walls": [wall.tolist() for wall in layout.walls],
            "solids": [solid.tolist() for solid in layout.solids],
            "carts": carts,
            "start": layout.start,
        }
    )


def layout_from_json(text: str) -> Layout:
    """Return the layout that `layout_to_json` wrote."""
    doc: dict[str, Any] = json.loads(text)
    x, y, yaw = doc["start"]
    return Layout(
        walls=tuple(np.array(points, float) for points in doc["walls"]),
        solids=tuple(np.array(points, float) for points in doc["solids"]),
        carts=tuple(
            Cart(np.array(c["polygon"], float), np.array(c["path"], float), bool(c["loop"]))
            for c in doc["carts"]
        ),
        start=(x, y, yaw),
    )
