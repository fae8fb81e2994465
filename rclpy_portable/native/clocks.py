"""Clocks, the points of time they show, and waiting for one of them."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter_ns  # monotonic_ns goes in steps of 16 ms on Windows
from typing import Any, NamedTuple

from . import machine
from .enums import ClockChange, ClockType
from .errors import RCLError
from .handles import Destroyable

JumpHook = Callable[[bool, ClockChange], None]  # before it happens?, what


class rcl_duration_t:  # noqa: N801  (its name in rclpy)
    """A span of time."""

    def __init__(self, nanoseconds: int) -> None:
        self.nanoseconds = nanoseconds


class rcl_time_point_t:  # noqa: N801
    """A point of time on a kind of clock."""

    def __init__(self, nanoseconds: int, clock_type: int) -> None:
        self.nanoseconds = nanoseconds
        self.clock_type = ClockType(clock_type)


class _Callback(NamedTuple):
    """What rclpy wants to hear of jumps."""

    handle: Any  # rclpy.clock.JumpHandle
    on_change: bool
    forward: int  # [ns] at least; 0: never
    backward: int  # [ns], negative; 0: never


class Clock(Destroyable):
    """A clock: of ROS (which can be set), of the system, or steady."""

    def __init__(self, clock_type: int) -> None:
        if clock_type not in (1, 2, 3):
            raise RCLError(f"failed to initialize clock: no clock is of type {clock_type}")
        self.type = ClockType(clock_type)
        self._override = 0  # [ns]
        self._active = False
        self._callbacks: list[_Callback] = []
        self.hooks: list[JumpHook] = []  # of timers

    def now(self) -> int:
        """Return what it shows [ns]."""
        if self.type == ClockType.STEADY_TIME:
            return perf_counter_ns()
        return self._override if self._active else machine.wall_ns()

    def get_now(self) -> rcl_time_point_t:
        """Return what it shows."""
        return rcl_time_point_t(self.now(), self.type)

    def get_ros_time_override_is_enabled(self) -> bool:
        """Return whether it shows what it was set to."""
        self._only_ros_time()
        return self._active

    def set_ros_time_override_is_enabled(self, enabled: bool) -> None:
        """Let it show what it was set to, or the time of the system."""
        self._only_ros_time()
        if enabled == self._active:
            return
        change = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
        told = [callback for callback in self._callbacks if callback.on_change]
        before = self.now()
        self._tell_before(told, change)
        self._active = enabled
        self._tell_after(told, change, self.now() - before)

    def set_ros_time_override(self, point: rcl_time_point_t) -> None:
        """Set it."""
        self._only_ros_time()
        delta = point.nanoseconds - self._override
        change = ClockChange.ROS_TIME_NO_CHANGE
        told = [c for c in self._callbacks if self._active and _is_far(c, delta)]
        self._tell_before(told, change)
        self._override = point.nanoseconds
        self._tell_after(told, change, delta)

    def add_clock_callback(self, handle: Any, on_change: bool, forward: int, backward: int) -> None:
        """Tell a JumpHandle of jumps: of a change of the source, of this far [ns]."""
        self._callbacks.append(_Callback(handle, on_change, forward, backward))

    def remove_clock_callback(self, handle: Any) -> None:
        """Tell a JumpHandle of no more jumps."""
        self._callbacks = [c for c in self._callbacks if c.handle is not handle]

    def _only_ros_time(self) -> None:
        if self.type != ClockType.ROS_TIME:
            raise RCLError("failed to set ROS time override: Clock is not of type RCL_ROS_TIME")

    def _tell_before(self, told: list[_Callback], change: ClockChange) -> None:
        for hook in list(self.hooks):
            hook(True, change)
        for callback in told:
            if callback.handle._pre_callback:
                callback.handle._pre_callback()

    def _tell_after(self, told: list[_Callback], change: ClockChange, delta: int) -> None:
        for hook in list(self.hooks):
            hook(False, change)
        for callback in told:
            if callback.handle._post_callback:
                callback.handle._post_callback({"clock_change": change, "delta": delta})
        if self.hooks:
            machine.changed()


def _is_far(callback: _Callback, delta: int) -> bool:
    forward = 0 < callback.forward <= delta
    return forward or delta <= callback.backward < 0


class ClockEvent:
    """An event that one waits for until a clock shows some time."""

    def __init__(self) -> None:
        self._state = False

    def set(self) -> None:
        """Wake those who wait."""
        self._state = True
        machine.changed()

    def clear(self) -> None:
        """Be not set any more."""
        self._state = False

    def is_set(self) -> bool:
        """Return whether it is set."""
        return self._state

    def wait_until_steady(self, clock: Clock, until: rcl_time_point_t) -> None:
        """Wait for it until the clock shows a time."""
        end = perf_counter_ns() + until.nanoseconds - clock.now()
        machine.wait_until(self.is_set, lambda: (end - perf_counter_ns()) / 1e9)

    wait_until_system = wait_until_steady

    def wait_until_ros(self, clock: Clock, until: rcl_time_point_t) -> None:
        """Wait for it; a clock that is set wakes those who wait itself (rclpy.clock does)."""
        if clock.get_ros_time_override_is_enabled():
            machine.wait_until(self.is_set, lambda: None)
        else:
            self.wait_until_steady(clock, until)
