"""The tree of frames: keeps transforms for a while, and composes those between two frames.

A transform a → b says where b is in a: it takes the coordinates of a point in b to those in a.
Between two stamps positions are interpolated linearly and rotations along the arc, as tf2 does.
"""

from __future__ import annotations

import bisect
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import rclpy
import rclpy.task
from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.time import Time

from .buffer_interface import BufferInterface
from .exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)
from .poses import IDENTITY, Pose, between, composed, inverse

CACHE = 10_000_000_000  # [ns] that a transform is kept
POLL = 0.01  # [s] between two looks while a lookup waits
DEPTH = 1000  # frames between a frame and its root, at most: more is a loop


@dataclass
class _Frame:
    """Where a frame is in its parent, over time."""

    parent: str
    static: bool
    authority: str
    stamps: list[int] = field(default_factory=list)  # [ns], in order
    poses: list[Pose] = field(default_factory=list)

    def at(self, stamp: int) -> Pose:
        """Return the pose at a time [ns]."""
        if self.static:
            return self.poses[-1]
        first, last = self.stamps[0], self.stamps[-1]
        if not first <= stamp <= last:
            early = stamp < first
            way, end = ("past", "earliest") if early else ("future", "latest")
            said = (
                f"into the {way}.  Requested time {stamp / 1e9:.6f} but the {end} data is at time "
                f"{(first if early else last) / 1e9:.6f}"
            )
            if first == last:
                said = f"at time {stamp / 1e9:.6f}, but only time {last / 1e9:.6f} is in the buffer"
            raise ExtrapolationException(f"Lookup would require extrapolation {said}")
        right = bisect.bisect_left(self.stamps, stamp)
        if self.stamps[right] == stamp:
            return self.poses[right]
        before, after = self.stamps[right - 1], self.stamps[right]
        part = (stamp - before) / (after - before)
        return between(self.poses[right - 1], self.poses[right], part)


class Buffer(BufferInterface):
    """Keeps the transforms that a listener hears, and answers where one frame is in another.

    Parameters
    ----------
    cache_time
        How long a transform is kept; 10 s by default.
    node
        Only for its service in tf2; nothing here.
    """

    def __init__(self, cache_time: Duration | None = None, node: Any = None) -> None:
        super().__init__()
        self._cache = CACHE if cache_time is None else cache_time.nanoseconds
        self._frames: dict[str, _Frame] = {}
        self._lock = threading.RLock()
        self._waiting: list[Callable[[], None]] = []  # looks of coroutines that wait

    def set_transform(self, transform: Any, authority: str) -> None:
        """Keep a TransformStamped.

        Raises InvalidArgumentException: its frames or numbers are not valid.
        """
        self._set(transform, authority, static=False)

    def set_transform_static(self, transform: Any, authority: str) -> None:
        """Keep a TransformStamped that holds at all times; raises as `set_transform`."""
        self._set(transform, authority, static=True)

    def lookup_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Any,
        timeout: Duration = Duration(),  # noqa: B008  (as tf2_ros has it)
    ) -> Any:
        """Return where `source_frame` is in `target_frame`, a TransformStamped.

        Raises TransformException: one of its kinds: LookupException, ConnectivityException,
        ExtrapolationException.

        Parameters
        ----------
        target_frame, source_frame
            The transform takes coordinates in the source to those in the target.
        time
            When, of rclpy or of a message; zero: at the newest time that is known.
        timeout
            How long to wait for it. Only where another thread spins.
        """
        self.can_transform(target_frame, source_frame, time, timeout)
        return self.lookup_transform_core(target_frame, source_frame, time)

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Any,
        timeout: Duration = Duration(),  # noqa: B008
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether `lookup_transform` would succeed; with the reason if it is asked for."""
        found = self._wait(
            lambda: self.can_transform_core(target_frame, source_frame, time), timeout
        )
        return found if return_debug_tuple else found[0]

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Duration = Duration(),  # noqa: B008
    ) -> Any:
        """Return where `source_frame` was at one time in `target_frame` at another.

        Parameters
        ----------
        target_time, source_time
            As the time of `lookup_transform`, which it otherwise follows.
        fixed_frame
            One that does not move between the two, such as "odom".
        """
        ends = target_frame, target_time, source_frame, source_time, fixed_frame
        self.can_transform_full(*ends, timeout)
        return self.lookup_transform_full_core(*ends)

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Duration = Duration(),  # noqa: B008
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether `lookup_transform_full` would succeed, as `can_transform` does."""
        ends = target_frame, target_time, source_frame, source_time, fixed_frame
        found = self._wait(lambda: self.can_transform_full_core(*ends), timeout)
        return found if return_debug_tuple else found[0]

    async def lookup_transform_async(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Wait for a transform in a coroutine, and return it."""
        await self.wait_for_transform_async(target_frame, source_frame, time)
        return self.lookup_transform_core(target_frame, source_frame, time)

    async def lookup_transform_full_async(self, *ends: Any, **named: Any) -> Any:
        """Wait for a transform between two times in a coroutine, and return it."""
        await self.wait_for_transform_full_async(*ends, **named)
        return self.lookup_transform_full_core(*ends, **named)

    def wait_for_transform_async(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return a future that is done once there is the transform."""
        return self._future(lambda: self.can_transform_core(target_frame, source_frame, time))

    def wait_for_transform_full_async(self, *ends: Any, **named: Any) -> Any:
        """Return a future that is done once there is the transform between two times."""
        return self._future(lambda: self.can_transform_full_core(*ends, **named))

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return a transform that is there; raises as `lookup_transform`."""
        return self._lookup(target_frame, source_frame, _nanoseconds(time))

    def can_transform_core(
        self, target_frame: str, source_frame: str, time: Any
    ) -> tuple[bool, str]:
        """Return whether there is a transform now, and why not."""
        return _tried(lambda: self.lookup_transform_core(target_frame, source_frame, time))

    def lookup_transform_full_core(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> Any:
        """Return a transform between two times that is there; raises as `lookup_transform`."""
        first = self.lookup_transform_core(fixed_frame, source_frame, source_time)
        second = self.lookup_transform_core(target_frame, fixed_frame, target_time)
        pose = composed(pose_of(second.transform), pose_of(first.transform))
        stamp = _nanoseconds(second.header.stamp)
        return _message(target_frame.lstrip("/"), source_frame.lstrip("/"), stamp, pose)

    def can_transform_full_core(self, *ends: Any, **named: Any) -> tuple[bool, str]:
        """Return whether there is a transform between two times now, and why not."""
        return _tried(lambda: self.lookup_transform_full_core(*ends, **named))

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Time:
        """Return the newest time at which both frames are known; raises as `lookup_transform`."""
        with self._lock:
            return Time(nanoseconds=self._path(target_frame, source_frame, 0)[0])

    def all_frames_as_yaml(self) -> str:
        """Return the frames with their parents and times, as YAML."""
        lines = []
        with self._lock:
            for name, frame in self._frames.items():
                oldest, newest = frame.stamps[0] / 1e9, frame.stamps[-1] / 1e9
                rate = len(frame.stamps) / max(newest - oldest, 1e-4)
                lines += [
                    f"{name}: ", f"  parent: '{frame.parent}'",
                    f"  broadcaster: '{frame.authority}'", f"  rate: {rate:.3f}",
                    f"  most_recent_transform: {newest:.6f}", f"  oldest_transform: {oldest:.6f}",
                    f"  buffer_length: {newest - oldest:.3f}",
                ]  # fmt: skip
        return "\n".join(lines) + "\n" if lines else "{}"

    def all_frames_as_string(self) -> str:
        """Return a line for each frame."""
        with self._lock:
            lines = [f"Frame {n} exists with parent {f.parent}." for n, f in self._frames.items()]
        return "\n".join(lines)

    def _getFrameStrings(self) -> list[str]:  # noqa: N802  (as tf2_py calls it)
        with self._lock:
            pairs = [(frame.parent, name) for name, frame in self._frames.items()]
        return list(dict.fromkeys(name for pair in pairs for name in pair))

    def _frameExists(self, frame_id: str) -> bool:  # noqa: N802
        return frame_id.lstrip("/") in self._getFrameStrings()

    def clear(self) -> None:
        """Forget everything but the static transforms."""
        with self._lock:
            self._frames = {name: f for name, f in self._frames.items() if f.static}

    def _set(self, transform: Any, authority: str, *, static: bool) -> None:
        self._keep(transform, authority, static=static)
        for look in list(self._waiting):
            look()

    def _keep(self, transform: Any, authority: str, *, static: bool) -> None:
        parent = transform.header.frame_id.lstrip("/")
        child = transform.child_frame_id.lstrip("/")
        pose = pose_of(transform.transform)
        length = math.fsum(part * part for part in pose[1])
        if not parent or not child or parent == child:
            raise InvalidArgumentException(f"transform from [{parent}] to [{child}]: bad frames")
        if not all(map(math.isfinite, (*pose[0], *pose[1]))) or abs(length - 1.0) > 0.01:
            raise InvalidArgumentException(f"transform from [{parent}] to [{child}]: bad numbers")
        stamp = Time.from_msg(transform.header.stamp).nanoseconds
        with self._lock:
            frame = self._frames.get(child)
            if frame is None or frame.parent != parent or frame.static or static:
                self._frames[child] = _Frame(parent, static, authority, [stamp], [pose])
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

    def _wait(self, look: Callable[[], tuple[bool, str]], timeout: Duration) -> tuple[bool, str]:
        """Wait until the transform is there; return whether it is, and why not."""
        end = time.monotonic() + timeout.nanoseconds / 1e9
        while not (found := look())[0] and time.monotonic() < end and rclpy.ok():
            time.sleep(POLL)
        return found

    def _future(self, look: Callable[[], tuple[bool, str]]) -> Any:
        """Return a future that is done once `look` finds a transform."""
        future: Any = rclpy.task.Future()

        def on_new_data() -> None:
            if not future.done() and look()[0]:
                future.set_result(True)

        def forget(_: Any) -> None:
            if on_new_data in self._waiting:
                self._waiting.remove(on_new_data)

        self._waiting.append(on_new_data)
        future.add_done_callback(forget)
        on_new_data()
        return future

    def _lookup(self, target: str, source: str, when: int) -> Any:
        target, source = target.lstrip("/"), source.lstrip("/")
        with self._lock:
            stamp, up, down = self._path(target, source, when)
            pose = there = IDENTITY
            try:
                for name in down:
                    pose = composed(pose, inverse(self._frames[name].at(stamp)))
                for name in up:
                    there = composed(self._frames[name].at(stamp), there)
            except ExtrapolationException as error:
                raise ExtrapolationException(
                    f"{error}, when looking up transform from frame [{source}] to frame [{target}]"
                ) from None
        return _message(target, source, stamp, composed(pose, there))

    def _path(self, target: str, source: str, stamp: int) -> tuple[int, list[str], list[str]]:
        """Return the time, and the frames from source and from target up to what they share."""
        down, up = self._to_root(target, "target"), self._to_root(source, "source")
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

    def _to_root(self, name: str, end: str) -> list[str]:
        if not self._frameExists(name):
            raise LookupException(
                f'"{name}" passed to lookupTransform argument {end}_frame does not exist. '
            )
        path = [name]
        while path[-1] in self._frames:
            path.append(self._frames[path[-1]].parent)
            if len(path) > DEPTH:
                raise LookupException(f"The tree of frames has a loop at [{name}]")
        return path


def _nanoseconds(when: Any) -> int:
    """Return a time of rclpy or of a message [ns]."""
    return int(
        when.nanoseconds if hasattr(when, "nanoseconds") else Time.from_msg(when).nanoseconds
    )


def _tried(look: Callable[[], Any]) -> tuple[bool, str]:
    try:
        look()
    except TransformException as error:
        return False, str(error)
    return True, ""


def pose_of(transform: Any) -> Pose:
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
