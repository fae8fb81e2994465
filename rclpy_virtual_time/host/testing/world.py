"""The world of a test in virtual time: its nodes' surroundings.

::

    def test_stops(virtual_time):
        with virtual_time() as world:
            heard = world.listen("/cmd_vel", Twist)
            world.publish("/scan", wall_ahead, at=0.5)
            world.run(Agent(), until=1.0)
        assert heard[-1].linear.x == 0.0
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any

import rclpy
import rclpy.executors
import rclpy.serialization
from rclpy.qos import QoSProfile, ReliabilityPolicy

from .alone import Alone

DEPTH = 5_000  # messages that are heard at one moment
NODE = "test"  # which the test's own messages come from


class Heard(Sequence[Any]):
    """The messages of one topic, in the order in which they came, and when each came."""

    def __init__(self, subscription: Any, now: Any) -> None:
        self._subscription = subscription
        self._now = now
        self._messages: list[Any] = []
        self._times: list[float] = []

    def __len__(self) -> int:
        self.take()
        return len(self._messages)

    def __getitem__(self, index: Any) -> Any:
        self.take()
        return self._messages[index]

    def __repr__(self) -> str:
        return f"<{len(self)} messages on {self._subscription.topic_name}>"

    @property
    def times(self) -> list[float]:
        """When each message came [s], from the block's begin on."""
        self.take()
        return list(self._times)

    def take(self) -> None:
        """Take the messages that have come by now."""
        handle, kind = self._subscription.handle, self._subscription.msg_type
        with handle:
            while (taken := handle.take_message(kind, False)) is not None:
                self._messages.append(taken[0])
                self._times.append(self._now())

    def close(self) -> None:
        """Take the last messages."""
        self.take()
        self.take = lambda: None  # type: ignore[method-assign]


class World:
    """The nodes' surroundings: the clock, and messages from and to the test.

    All times are in seconds since the block began.
    """

    def __init__(self, alone: Alone) -> None:
        self._alone = alone
        self._kernel = alone.kernel
        self._start = alone.kernel.now
        self._own: Any = None
        self._publishers: dict[tuple[str, Any], Any] = {}
        self._heard: list[Heard] = []
        self._open = True
        self._alone.watchers.append(self._take)

    @property
    def now(self) -> float:
        """The time [s]."""
        return (self._kernel.now - self._start) / 1e9

    def stamp(self, at: float | None = None) -> Any:
        """Return a time [s] as ROS messages have it in their header; without one, the present."""
        shift = 0 if at is None else self._moment(at) - self._kernel.now
        now = self._alone.clocks.now()
        return (now + rclpy.duration.Duration(nanoseconds=shift)).to_msg()

    def listen(self, topic: str, kind: Any) -> Heard:
        """Hear all messages of a topic from now on, from any publisher in any QoS."""
        qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
        subscription = self._node().create_subscription(kind, topic, lambda _: None, qos)
        self._heard.append(Heard(subscription, lambda: self.now))
        return self._heard[-1]

    def publish(self, topic: str, message: Any, at: float | None = None, qos: Any = 10) -> None:
        """Send a message as it is now, at a time [s]; without one, at once.

        Raises ValueError: that time is over.
        """
        moment = self._kernel.now if at is None else self._moment(at)
        if moment < self._kernel.now:
            raise ValueError(f"publish(at={at}): it is {self.now:g} s already")
        key = (topic, type(message))
        if key not in self._publishers:
            self._publishers[key] = self._node().create_publisher(type(message), topic, qos)
        publisher, data = self._publishers[key], rclpy.serialization.serialize_message(message)
        if moment == self._kernel.now:
            publisher.publish(data)
        else:
            self._kernel.call_at(moment, lambda: publisher.publish(data) if self._open else None)

    def run(self, *nodes: Any, until: float, executor: Any = None) -> None:
        """Let nodes spin until a time [s]; without nodes, let time pass.

        What is due at that time is done, too. The nodes share an executor: a single-threaded one,
        if none is given. What they raise, it raises.

        Raises ValueError: that time is over.
        """
        end = self._moment(until)
        if end < self._kernel.now:
            raise ValueError(f"run(until={until}): it is {self.now:g} s already")
        if not nodes and executor is None:
            for _ in range(2):  # once that time is there, once all is done that is due then
                self._kernel.park(end)
            return
        spinner = executor or rclpy.executors.SingleThreadedExecutor()
        for node in nodes:
            spinner.add_node(node)
        try:
            while rclpy.ok() and end > self._kernel.now:
                left = max(1, end - self._kernel.present)
                spinner.spin_once(timeout_sec=left / 1e9)
            self._settle(spinner, end)
        finally:
            for node in nodes:
                spinner.remove_node(node)
            if executor is None:
                spinner.shutdown()

    def close(self) -> None:
        """Hear the last messages, and say no more."""
        for heard in self._heard:
            heard.close()
        self._open = False
        self._alone.watchers.remove(self._take)

    def _settle(self, spinner: Any, end: int) -> None:
        """Let an executor and its threads do the work that is left at this moment."""
        thread = self._kernel.me()
        while rclpy.ok() and self._kernel.now <= end:  # a callback may have slept past it
            self._kernel.park(self._kernel.now)
            thread.idle.pop(spinner, None)
            spinner.spin_once(timeout_sec=0)
            if spinner in thread.idle:  # it found nothing
                return

    def _take(self) -> None:
        for heard in self._heard:
            heard.take()

    def _moment(self, at: float) -> int:
        return self._start + round(at * 1e9)

    def _node(self) -> Any:
        """Return the test's own node; there is none until the test speaks or listens."""
        if self._own is None:
            none = dict.fromkeys(("start_parameter_services", "enable_rosout"), False)
            self._own = rclpy.create_node(NODE, use_global_arguments=False, **none)
        return self._own


class VirtualTime:
    """What the fixture `virtual_time` gives: called, it opens a block with rclpy and a world."""

    def __init__(self, alone: Alone) -> None:
        self._alone = alone

    @contextlib.contextmanager
    def __call__(self, args: Sequence[str] | None = None) -> Iterator[World]:
        """Call `rclpy.init` with these arguments, and shut rclpy down when the block ends."""
        rclpy.init(args=[] if args is None else list(args))
        world = World(self._alone)
        try:
            yield world
        finally:
            world.close()
            rclpy.try_shutdown()
