"""A stand-in for the package message_filters, which has no wheel.

Here are its subscriber, cache and two synchronizers.
"""

# ruff: noqa: N802  (names as message_filters has them)

import itertools
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.clock import ROSClock
from rclpy.duration import Duration
from rclpy.time import Time

print(
    "message_filters: pip has no package of it, so this is a stand-in; "
    "`source /opt/ros/…/setup.bash` before the start brings ROS's own",
    file=sys.stderr,
)


class SimpleFilter:
    """Hands messages on to the registered callbacks."""

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., Any], tuple[Any, ...]]] = {}

    def registerCallback(self, cb: Callable[..., Any], *args: Any) -> int:
        """Let `cb` be called with each message, or set of messages, and these arguments."""
        self.callbacks[len(self.callbacks)] = (cb, args)
        return len(self.callbacks) - 1

    def signalMessage(self, *msg: Any) -> None:
        """Hand on a message, or a set of them."""
        for callback, args in list(self.callbacks.values()):
            callback(*msg, *args)


class Subscriber(SimpleFilter):
    """Hands on the messages of a topic; what follows the topic is for `create_subscription`."""

    def __init__(self, node: Any, msg_type: Any, topic: str, **kwargs: Any) -> None:
        super().__init__()
        self.node, self.topic = node, topic
        kwargs.setdefault("qos_profile", 10)
        self.sub = node.create_subscription(msg_type, topic, self.signalMessage, **kwargs)


class Cache(SimpleFilter):
    """Keeps the last `cache_size` messages of a filter, and hands each on."""

    def __init__(self, f: Any = None, cache_size: int = 1, allow_headerless: bool = False) -> None:
        super().__init__()
        self.cache_size, self.allow_headerless = cache_size, allow_headerless
        self._kept: list[tuple[Time, Any]] = []
        if f is not None:
            f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Keep a message; one without a header only if that is allowed, at the present."""
        if (time := _time_of(msg, self.allow_headerless)) is None:
            return
        self._kept = sorted([*self._kept, (time, msg)], key=lambda each: each[0].nanoseconds)
        del self._kept[: -self.cache_size]
        self.signalMessage(msg)

    def getInterval(self, from_stamp: Time, to_stamp: Time) -> list[Any]:
        """Return the messages between two times, both included."""
        return [msg for time, msg in self._kept if from_stamp <= time <= to_stamp]

    def getElemAfterTime(self, stamp: Time) -> Any:
        """Return the oldest message that is not before a time; None if there is none."""
        return next((msg for time, msg in self._kept if time >= stamp), None)

    def getElemBeforeTime(self, stamp: Time) -> Any:
        """Return the newest message that is not after a time; None if there is none."""
        return next((msg for time, msg in reversed(self._kept) if time <= stamp), None)

    def getLast(self) -> Any:
        """Return the newest message."""
        return self._kept[-1][1] if self._kept else None


class ApproximateTimeSynchronizer(SimpleFilter):
    """Hands on sets, a message of each filter, whose stamps differ by less than `slop` [s]."""

    def __init__(
        self, fs: Sequence[Any], queue_size: int, slop: float, allow_headerless: bool = False
    ) -> None:
        super().__init__()
        self.queue_size, self.allow_headerless = queue_size, allow_headerless
        self.slop = Duration(seconds=slop).nanoseconds
        self.queues: list[dict[int, Any]] = [{} for _ in fs]  # by stamp [ns]
        self.lock = threading.Lock()
        for each, queue in zip(fs, self.queues, strict=True):
            each.registerCallback(self.add, queue)

    def add(self, msg: Any, queue: dict[int, Any]) -> None:
        """Keep a message of a filter; hand on the set with those nearest to it, if there is one."""
        if (time := _time_of(msg, self.allow_headerless)) is None:
            return
        now = time.nanoseconds
        with self.lock:
            queue[now] = msg
            for old in sorted(queue)[: -self.queue_size]:
                del queue[old]
            near = [
                sorted((s for s in each if abs(s - now) < self.slop), key=lambda s: abs(s - now))
                for each in self.queues
            ]
            for stamps in itertools.product(*near):
                if now in stamps and max(stamps) - min(stamps) < self.slop:
                    pairs = zip(self.queues, stamps, strict=True)
                    self.signalMessage(*[each.pop(stamp) for each, stamp in pairs])
                    return


class TimeSynchronizer(ApproximateTimeSynchronizer):
    """Hands on sets of messages, one of each filter, with the same stamp."""

    def __init__(self, fs: Sequence[Any], queue_size: int) -> None:
        super().__init__(fs, queue_size, slop=1e-9)


def _time_of(msg: Any, headerless: bool) -> Time | None:
    if hasattr(msg, "header"):
        return Time.from_msg(msg.header.stamp)
    return ROSClock().now() if headerless else None
