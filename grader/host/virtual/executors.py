"""Put the kernel under rclpy: the wait of its executors, its clocks and its timers.

The student's own executor runs unchanged; only the places where it would wait for real are
replaced. Written against rclpy 7.1 (Jazzy).
"""

from __future__ import annotations

import functools
import inspect
import os
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import rclpy.clock
import rclpy.executors
import rclpy.impl.rcutils_logger
import rclpy.node
import rclpy.task
import rclpy.time_source
import rclpy.wait_for_message
from rclpy.clock_type import ClockType
from rclpy.event_handler import EventHandler
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.time import Time

from .bridge import Bridge
from .kernel import Kernel
from .threads import STEADY_START


class RosClocks:
    """All ROS clocks of the process, set directly.

    (A /clock message would have to pass through the student's own executor, where it could wait
    behind the student's own callbacks.)
    """

    def __init__(self, kernel: Kernel, epoch: int) -> None:
        self._kernel = kernel
        self._epoch = epoch
        self._clocks: list[Any] = []

    def now(self) -> Any:
        """Return the ROS time."""
        return Time(nanoseconds=self._epoch + self._kernel.now, clock_type=ClockType.ROS_TIME)

    def add(self, clock: Any) -> None:
        """Take charge of a clock."""
        self._clocks.append(clock)
        clock.set_ros_time_override(self.now())
        clock._set_ros_time_is_active(True)

    def follow(self) -> None:
        """Set every clock to the present: timers that are due become ready."""
        now = self.now()
        for clock in self._clocks:
            clock.set_ros_time_override(now)


def install(kernel: Kernel, epoch: int, bridge: Bridge) -> RosClocks:
    """Replace the waiting parts of rclpy; return the clocks, which must follow the kernel."""
    _install_entities(bridge)
    clocks = RosClocks(kernel, epoch)
    _install_wait(kernel, bridge)
    _install_wait_for_message(kernel)
    _install_tasks(kernel)
    _install_clocks(kernel, clocks)
    _quicken_log()
    return clocks


def refuse_real_time(leave: Callable[[str], None]) -> None:
    """Call `leave`, with the reason, when the student uses what can't be made virtual."""
    native: Any = rclpy_implementation
    native.EventsExecutor = lambda *_: leave(
        "EventsExecutor waits for DDS in native code, where virtual time does not reach"
    )


def _install_wait(kernel: Kernel, bridge: Bridge) -> None:
    """Let executors wait in the kernel. They look with a timeout of zero, as often as needed."""
    cls: Any = rclpy.executors.Executor
    wait = cls.wait_for_ready_callbacks

    def look(self: Any, nodes: Any, condition: Any) -> Any:
        while True:
            try:
                found = wait(self, 0, nodes, condition)
            except rclpy.executors.TimeoutException:
                # With a timeout of 0 rclpy says "timeout" also at the end of a look that gave
                # work: only a fresh look that gives nothing means there is nothing.
                if not self.__dict__.pop("_course_gave_work", False):
                    for node in nodes or self.get_nodes():
                        node._course_changes = bridge.changes  # their events have been seen
                    return None
                continue
            if _is_new(kernel, found[0]):
                self._course_gave_work = True
                return found

    def virtual_wait(
        self: Any, timeout_sec: Any = None, nodes: Any = None, condition: Any = lambda: False
    ) -> Any:
        seconds = getattr(timeout_sec, "timeout", timeout_sec)
        deadline = None if seconds is None or seconds < 0 else kernel.after(seconds)
        found = kernel.poll(
            self,
            lambda: look(self, nodes, condition),
            deadline,
            lambda: _next_timer(kernel, nodes or self.get_nodes()),
        )
        if found is None:
            raise rclpy.executors.TimeoutException
        return found

    def nodes_in_order(self: Any) -> list[Any]:
        """The executor keeps a set, whose order changes from run to run."""
        return sorted(self._nodes, key=lambda node: node.get_fully_qualified_name())

    cls.wait_for_ready_callbacks = virtual_wait
    cls.get_nodes = nodes_in_order


def _install_wait_for_message(kernel: Kernel) -> None:
    """`rclpy.wait_for_message` waits without an executor, for one message of one topic."""
    module: Any = rclpy.wait_for_message

    def virtual_wait_for_message(
        msg_type: Any, node: Any, topic: str, *, qos_profile: Any = 1, time_to_wait: float = -1
    ) -> tuple[bool, Any]:
        subscription = node.create_subscription(msg_type, topic, lambda _: None, qos_profile)
        deadline = None if time_to_wait < 0 else kernel.after(time_to_wait)
        try:
            taken = kernel.poll(
                subscription, lambda: subscription.handle.take_message(msg_type, False), deadline
            )
        finally:
            node.destroy_subscription(subscription)
        return (False, None) if taken is None else (True, taken[0])

    module.wait_for_message = virtual_wait_for_message


def _is_new(kernel: Kernel, task: Any) -> bool:
    """Tell whether a task that an executor offers deserves to be handed out.

    Not if it was handed out and still queues in the thread pool (rclpy#1452 offers it again and
    again), nor if it is a coroutine that was tried already since anything changed.
    """
    if getattr(task, "_course_queued", False):
        return False
    if getattr(task, "_course_tried", None) == kernel.epoch:
        return False
    if not hasattr(task, "_course_queued"):
        kernel.epoch += 1
    task._course_queued = True
    task._course_tried = kernel.epoch
    return True


def _next_timer(kernel: Kernel, nodes: Any) -> int | None:
    """Return when the next timer is due [ns]; one that is due already waits for something else."""
    remaining = (
        timer.time_until_next_call()
        for node in nodes
        for timer in node.timers
        if not timer.is_canceled()
    )
    return min((kernel.now + ns for ns in remaining if ns is not None and ns > 0), default=None)


def _install_entities(bridge: Bridge) -> None:
    """Spare executors what can't become ready: half of the cost of a look.

    Nobody outside the process reaches a node's parameter services, so without a client inside they
    are never called; and QoS events tell of endpoints that appear, so nothing comes between.
    """
    cls: Any = rclpy.node.Node
    all_waitables = cls.waitables.fget

    def services(self: Any) -> Iterator[Any]:
        for service in self._services:
            if bridge.parameters_in_use or not service.__dict__.get("_course_parameters"):
                yield service

    def waitables(self: Any) -> Iterator[Any]:
        changed = self.__dict__.get("_course_changes") != bridge.changes
        for waitable in all_waitables(self):
            if changed or not isinstance(waitable, EventHandler):
                yield waitable

    cls.services, cls.waitables = property(services), property(waitables)


def _install_tasks(kernel: Kernel) -> None:
    cls: Any = rclpy.task.Task
    call = cls.__call__

    def virtual_call(self: Any) -> Any:
        self._course_queued = False
        return call(self)

    future: Any = rclpy.task.Future
    notify = future._schedule_or_invoke_done_callbacks

    def virtual_notify(self: Any) -> None:
        kernel.epoch += 1  # a coroutine may be waiting for this future
        notify(self)

    cls.__call__ = virtual_call
    future._schedule_or_invoke_done_callbacks = virtual_notify


def _install_clocks(kernel: Kernel, clocks: RosClocks) -> None:
    source: Any = rclpy.time_source.TimeSource
    attach = source.attach_clock

    def virtual_attach(self: Any, clock: Any) -> None:
        attach(self, clock)
        clocks.add(clock)

    source.attach_clock = virtual_attach

    clock_cls: Any = rclpy.clock.Clock
    real_now = clock_cls.now

    def virtual_now(self: Any) -> Any:
        if self.clock_type == ClockType.ROS_TIME:
            return real_now(self)
        start = clocks._epoch if self.clock_type == ClockType.SYSTEM_TIME else STEADY_START
        return Time(nanoseconds=start + kernel.now, clock_type=self.clock_type)

    def virtual_sleep_until(self: Any, until: Any, context: Any = None) -> bool:
        remaining = until.nanoseconds - self.now().nanoseconds
        kernel.park(kernel.now + max(0, remaining))
        return True

    clock_cls.now = virtual_now
    clock_cls.sleep_until = virtual_sleep_until

    node_cls: Any = rclpy.node.Node
    create_timer = node_cls.create_timer

    def virtual_create_timer(
        self: Any,
        timer_period_sec: float,
        callback: Any,
        callback_group: Any = None,
        clock: Any = None,
        **kwargs: Any,
    ) -> Any:
        if clock is not None and clock.clock_type != ClockType.ROS_TIME:
            clock = None  # system and steady time are the same virtual time as the node's clock
        return create_timer(self, timer_period_sec, callback, callback_group, clock, **kwargs)

    node_cls.create_timer = virtual_create_timer


def _quicken_log() -> None:
    """Let a log line find its caller's file without looking for the source; that took 0.4 ms."""
    module: Any = rclpy.impl.rcutils_logger
    module.inspect = SimpleNamespace(
        currentframe=inspect.currentframe,
        getframeinfo=lambda frame: SimpleNamespace(filename=frame.f_code.co_filename),
    )
    realpath = functools.lru_cache(os.path.realpath)
    module.os = SimpleNamespace(path=SimpleNamespace(realpath=realpath, abspath=os.path.abspath))
