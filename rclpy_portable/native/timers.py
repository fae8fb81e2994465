"""Timers: when they are due, by which clock (rcl/timer.c, Jazzy)."""

from __future__ import annotations

from . import machine
from .clocks import Clock
from .enums import ClockChange
from .errors import RCLError
from .handles import Destroyable


class Timer(Destroyable):
    """When to act by a clock."""

    def __init__(self, clock: Clock, period: int, autostart: bool) -> None:
        if period < 0:
            raise RCLError("failed to create timer: timer period must be non-negative")
        self._clock = clock
        self._period = period  # [ns]
        self._canceled = not autostart
        self._last = clock.now()
        self._next = self._last + period
        self._left: int | None = None  # [ns] of the period, while the clock's source changes
        clock.hooks.append(self._jump)

    @property
    def ready(self) -> bool:
        """It is due."""
        return not self._canceled and self._next <= self._clock.now()

    def is_timer_ready(self) -> bool:
        """Return whether it is due."""
        return self.ready

    def call_timer(self) -> None:
        """Begin the next period; those that were missed, or end just now, are left out."""
        if self._canceled:
            raise RCLError("failed to call timer: timer is canceled")
        now = self._clock.now()
        self._last = now
        self._next += self._period
        if self._next <= now:
            missed = (now - self._next) // self._period + 1 if self._period else 0
            self._next = self._next + missed * self._period if self._period else now

    def cancel_timer(self) -> None:
        """Let it be due no more."""
        self._canceled = True

    def is_timer_canceled(self) -> bool:
        """Return whether it was canceled."""
        return self._canceled

    def reset_timer(self) -> None:
        """Begin the period now, also of a timer that was canceled."""
        self._next = self._clock.now() + self._period
        self._canceled = False
        machine.changed()

    def time_until_next_call(self) -> int | None:
        """Return the time until it is due [ns]; None if it was canceled."""
        return None if self._canceled else self._next - self._clock.now()

    def time_since_last_call(self) -> int:
        """Return the time since it was called [ns]."""
        return self._clock.now() - self._last

    def get_timer_period(self) -> int:
        """Return the period [ns]."""
        return self._period

    def change_timer_period(self, period: int) -> None:
        """Set the period [ns], from the next one on."""
        self._period = period

    def _jump(self, before: bool, change: ClockChange) -> None:
        """Keep what is left of the period when the clock's source changes, or time goes back."""
        changes = change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED)
        now = self._clock.now()
        if before:
            self._left = self._next - now if changes and now else None
        elif changes:
            if self._left is not None and now:
                self._next = now + self._left
                self._last = self._next - self._period
        elif now < self._last:
            self._next = now + self._period
            self._last = now

    def _destroy(self) -> None:
        self._clock.hooks.remove(self._jump)


class ContextTimer(Timer):
    """A timer as rclpy makes it; the context would wake executors, which all changes do here."""

    def __init__(self, clock: Clock, _context: object, period: int, autostart: bool) -> None:
        super().__init__(clock, period, autostart)
