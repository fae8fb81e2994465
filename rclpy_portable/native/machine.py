"""The machine's own time, and waiting in it, for what DDS and rcl do in native code.

A program that puts virtual time under Python's clocks and locks imports this module first: what is
taken from `time` and `_thread` here stays real.
"""

from __future__ import annotations

import _thread
from collections.abc import Callable
from time import perf_counter_ns, time_ns  # monotonic_ns goes in steps of 16 ms on Windows

_OFFSET = time_ns() - perf_counter_ns()  # [ns]; `time.time_ns` itself may be replaced in C


class _Stamps:
    """Times of messages: each later than the one before, however coarse the clock."""

    def __init__(self) -> None:
        self.clock: Callable[[], int] = lambda: perf_counter_ns() + _OFFSET
        self._last = 0

    def next(self) -> int:
        """Return the time since 1970 [ns]."""
        self._last = max(self._last + 1, self.clock())
        return self._last


stamps = _Stamps()


def wall_ns() -> int:
    """Return the time since 1970 [ns]."""
    return stamps.clock()


def use_clock(clock: Callable[[], int]) -> None:
    """Stamp messages by another clock [ns since 1970]."""
    stamps.clock = clock


_allocate_lock = _thread.allocate_lock


class _Waiter:
    """A thread that sleeps until something changes."""

    def __init__(self) -> None:
        self._lock = _allocate_lock()
        self._lock.acquire()

    def wait(self, seconds: float) -> None:
        self._lock.acquire(timeout=seconds)

    def wake(self) -> None:
        if self._lock.locked():
            try:
                self._lock.release()
            except RuntimeError:  # another thread was quicker
                return


_waiters: list[_Waiter] = []
LONGEST = 0.2  # [s] that a thread sleeps without looking at signals


def wait_until(ready: Callable[[], bool], remaining: Callable[[], float | None]) -> bool:
    """Sleep until `ready` is true, or until no time remains.

    Parameters
    ----------
    ready
        Asked after each change.
    remaining
        How long to wait at most [s]; None: for ever.
    """
    waiter = _Waiter()
    _waiters.append(waiter)
    try:
        while not ready():
            left = remaining()
            if left is not None and left <= 0:
                return False
            waiter.wait(LONGEST if left is None else min(left, LONGEST))
        return True
    finally:
        _waiters.remove(waiter)


def changed() -> None:
    """Let those who wait look again."""
    for waiter in list(_waiters):
        waiter.wake()
