"""The tree of frames: keeps transforms for a while, and composes those between two frames.

A transform a → b says where b is in a: it takes the coordinates of a point in b to those in a.
Between two stamps positions are interpolated linearly and rotations along the arc, as tf2 does.
"""

from __future__ import annotations

import bisect
import math
import threading
import time
from dataclasses import dataclass, field
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.time import Time

from .exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)

CACHE = 10_000_000_000  # [ns] that a transform is kept
POLL = 0.01  # [s] between two looks while a lookup waits
DEPTH = 1000  # frames between a frame and its root, at most: more is a loop

Vector = tuple[float, float, float]  # x, y, z [m]
Quaternion = tuple[float, float, float, float]  # x, y, z, w
Pose = tuple[Vector, Quaternion]

IDENTITY: Pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


@dataclass
class _Frame:
    """Where a frame is in its parent, over time."""

    parent: str
    static: bool
    stamps: list[int] = field(default_factory=list)  # [ns], in order
    poses: list[Pose] = field(default_factory=list)

    def at(self, stamp: int, name: str) -> Pose:
        """Return the pose at a time [ns]."""
        if self.static:
            return self.poses[-1]
        if not self.stamps[0] <= stamp <= self.stamps[-1]:
            way = "past" if stamp < self.stamps[0] else "future"
            raise ExtrapolationException(
                f"Lookup would require extrapolation into the {way}. Requested time "
                f"{stamp / 1e9:.6f} but the data of frame [{name}] goes from "
                f"{self.stamps[0] / 1e9:.6f} to {self.stamps[-1] / 1e9:.6f}"
            )
        right = bisect.bisect_left(self.stamps, stamp)
        if self.stamps[right] == stamp:
            return self.poses[right]
        before, after = self.stamps[right - 1], self.stamps[right]
        part = (stamp - before) / (after - before)
        return _between(self.poses[right - 1], self.poses[right], part)


class Buffer:
    """Keeps the transforms that a listener hears, and answers where one frame is in another.

    Parameters
    ----------
    cache_time
        How long a transform is kept; 10 s by default.
    node
        Only for its service in tf2; nothing here.
    """

    def __init__(self, cache_time: Duration | None = None, node: Any = None) -> None:
        self._cache = CACHE if cache_time is None else cache_time.nanoseconds
        self._frames: dict[str, _Frame] = {}
        self._lock = threading.RLock()

    def set_transform(self, transform: Any, authority: str) -> None:
        """Keep a TransformStamped.

        Raises
        ------
        InvalidArgumentException
            Its frames or numbers are not valid.
        """
        self._set(transform, static=False)

    def set_transform_static(self, transform: Any, authority: str) -> None:
        """Keep a TransformStamped that holds at all times; raises as `set_transform`."""
        self._set(transform, static=True)

    def lookup_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Time,
        timeout: Duration = Duration(),  # noqa: B008  (as tf2_ros has it)
    ) -> Any:
        """Return where `source_frame` is in `target_frame`, a TransformStamped.

        Parameters
        ----------
        target_frame, source_frame
            The transform takes coordinates in the source to those in the target.
        time
            When; zero: at the newest time that is known.
        timeout
            How long to wait for it. Only where another thread spins.

        Raises
        ------
        TransformException
            One of its kinds: LookupException, ConnectivityException, ExtrapolationException.
        """
        self._wait(target_frame, source_frame, time, timeout)
        return self._lookup(target_frame, source_frame, time)

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Time,
        timeout: Duration = Duration(),  # noqa: B008
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether `lookup_transform` would succeed; with the reason if it is asked for."""
        why = self._wait(target_frame, source_frame, time, timeout)
        return (not why, why) if return_debug_tuple else not why

    def all_frames_as_string(self) -> str:
        """Return a line for each frame."""
        with self._lock:
            lines = [f"Frame {n} exists with parent {f.parent}." for n, f in self._frames.items()]
        return "\n".join(lines)

    def clear(self) -> None:
        """Forget everything but the static transforms."""
        with self._lock:
            self._frames = {name: f for name, f in self._frames.items() if f.static}

    def _set(self, transform: Any, *, static: bool) -> None:
        parent = transform.header.frame_id.lstrip("/")
        child = transform.child_frame_id.lstrip("/")
        pose = _pose(transform.transform)
        length = math.fsum(part * part for part in pose[1])
        if not parent or not child or parent == child:
            raise InvalidArgumentException(f"transform from [{parent}] to [{child}]: bad frames")
        if not all(map(math.isfinite, (*pose[0], *pose[1]))) or abs(length - 1.0) > 0.01:
            raise InvalidArgumentException(f"transform from [{parent}] to [{child}]: bad numbers")
        stamp = Time.from_msg(transform.header.stamp).nanoseconds
        with self._lock:
            frame = self._frames.get(child)
            if frame is None or frame.parent != parent or frame.static or static:
                self._frames[child] = _Frame(parent, static, [stamp], [pose])
                return
            if stamp < frame.stamps[-1] - self._cache:
                return
            at = bisect.bisect_left(frame.stamps, stamp)
            if at < len(frame.stamps) and frame.stamps[at] == stamp:
                frame.poses[at] = pose
            else:
                frame.stamps.insert(at, stamp)
                frame.poses.insert(at, pose)
            old = bisect.bisect_left(frame.stamps, frame.stamps[-1] - self._cache)
            del frame.stamps[:old], frame.poses[:old]

    def _wait(self, target: str, source: str, when: Time, timeout: Duration) -> str:
        """Wait until the transform is there; return why it is not, "" if it is."""
        end = time.monotonic() + timeout.nanoseconds / 1e9
        while True:
            try:
                self._lookup(target, source, when)
            except TransformException as error:
                if time.monotonic() >= end:
                    return str(error)
                time.sleep(POLL)
            else:
                return ""

    def _lookup(self, target: str, source: str, when: Time) -> Any:
        target, source = target.lstrip("/"), source.lstrip("/")
        with self._lock:
            stamp, up, down = self._path(target, source, when.nanoseconds)
            pose = IDENTITY
            for name in down:
                pose = _composed(pose, _inverse(self._frames[name].at(stamp, name)))
            there = IDENTITY
            for name in up:
                there = _composed(self._frames[name].at(stamp, name), there)
        return _message(target, source, stamp, _composed(pose, there))

    def _path(self, target: str, source: str, stamp: int) -> tuple[int, list[str], list[str]]:
        """Return the time, and the frames from source and from target up to what they share."""
        up, down = self._to_root(source), self._to_root(target)
        if up[-1] != down[-1]:
            raise ConnectivityException(
                f"Could not find a connection between '{target}' and '{source}' because they are "
                "not part of the same tree. Tf has two or more unconnected trees."
            )
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        if not stamp:
            moving = [self._frames[name] for name in (*up, *down) if not self._frames[name].static]
            stamp = min((frame.stamps[-1] for frame in moving), default=0)
        return stamp, up, down

    def _to_root(self, name: str) -> list[str]:
        known = name in self._frames or any(f.parent == name for f in self._frames.values())
        if not known:
            raise LookupException(f'"{name}" passed to lookupTransform argument does not exist.')
        path = [name]
        while path[-1] in self._frames:
            path.append(self._frames[path[-1]].parent)
            if len(path) > DEPTH:
                raise LookupException(f"The tree of frames has a loop at [{name}]")
        return path


def _pose(transform: Any) -> Pose:
    t, r = transform.translation, transform.rotation
    return (t.x, t.y, t.z), (r.x, r.y, r.z, r.w)


def _message(target: str, source: str, stamp: int, pose: Pose) -> Any:
    message = TransformStamped()
    message.header.stamp = Time(nanoseconds=stamp).to_msg()
    message.header.frame_id, message.child_frame_id = target, source
    to, turn = message.transform.translation, message.transform.rotation
    to.x, to.y, to.z = pose[0]
    turn.x, turn.y, turn.z, turn.w = pose[1]
    return message


def _composed(first: Pose, second: Pose) -> Pose:
    """Return the pose of `second`, which is given in the frame `first`."""
    (x, y, z), turn = first
    dx, dy, dz = _turned(second[0], turn)
    return (x + dx, y + dy, z + dz), _product(turn, second[1])


def _inverse(pose: Pose) -> Pose:
    (x, y, z), (qx, qy, qz, qw) = pose
    back = (-qx, -qy, -qz, qw)
    dx, dy, dz = _turned((x, y, z), back)
    return (-dx, -dy, -dz), back


def _turned(vector: Vector, turn: Quaternion) -> Vector:
    qx, qy, qz, qw = turn
    x, y, z, _ = _product(_product(turn, (*vector, 0.0)), (-qx, -qy, -qz, qw))
    return x, y, z


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _between(a: Pose, b: Pose, part: float) -> Pose:
    x, y, z = (p + part * (q - p) for p, q in zip(a[0], b[0], strict=True))
    cosine = sum(p * q for p, q in zip(a[1], b[1], strict=True))
    sign = -1.0 if cosine < 0 else 1.0  # the short way
    angle = math.acos(min(1.0, abs(cosine)))
    if angle < 1e-9:
        return (x, y, z), a[1]
    first, second = (math.sin(share * angle) for share in (1.0 - part, part))
    qx, qy, qz, qw = (
        (first * p + sign * second * q) / math.sin(angle) for p, q in zip(a[1], b[1], strict=True)
    )
    return (x, y, z), (qx, qy, qz, qw)
