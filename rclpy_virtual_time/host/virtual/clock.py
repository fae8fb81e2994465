"""Put virtual time under Python's clocks: `time`, `datetime`, and the timer of SIGALRM.

`install` must run before the student's file is imported. CPU clocks (`process_time`, `thread_time`)
stay real: they measure the processor, not the time of day.
"""

from __future__ import annotations

import errno
import operator
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import _time_machine

from .kernel import Kernel, VirtualThread

_pytest: Any = sys.modules.setdefault("pytest", None)  # type: ignore[arg-type]
import time_machine  # noqa: E402  (with pytest it would import that, for a fixture)

if _pytest is None:
    del sys.modules["pytest"]

STEADY_START = 1_000 * 10**9  # [ns] monotonic clocks start here, as on a machine up for a while
COARSE = {5: "wall", 6: "steady", 8: "wall", 9: "steady"}  # ids of Linux that `time` does not name

real_time_ns: Callable[[], int] = _time_machine.original_time_ns  # when DDS stamps messages


class Clock:
    """The virtual readings of `time`, `monotonic` and `perf_counter`."""

    def __init__(self, kernel: Kernel, epoch: int) -> None:
        self._kernel = kernel
        self._epoch = epoch

    def wall(self) -> int:
        """Return the time since 1970 [ns]."""
        return self._epoch + self._kernel.show()

    def steady(self) -> int:
        """Return the time since some moment in the past [ns]."""
        return STEADY_START + self._kernel.show()


def install(kernel: Kernel, epoch: int) -> None:
    """Replace the clocks of this process by those of `kernel`; `epoch` is its time 0 [ns]."""
    clock = Clock(kernel, epoch)
    _install_time(kernel, clock)
    _install_datetime(clock)
    IntervalTimer(kernel).install()


def _install_time(kernel: Kernel, clock: Clock) -> None:
    module: Any = time
    module.sleep = lambda seconds: _sleep(kernel, seconds)
    module.time_ns, module.time = clock.wall, lambda: clock.wall() / 1e9
    for name in ("monotonic", "perf_counter"):
        setattr(module, f"{name}_ns", clock.steady)
        setattr(module, name, lambda: clock.steady() / 1e9)
    threading._time = queue.time = module.monotonic  # type: ignore[attr-defined]
    _install_calendar(module, clock)
    _install_clock_ids(module, clock)
    _install_times(clock)


def _install_calendar(module: Any, clock: Clock) -> None:
    """Give today's virtual date to the functions that take the present if they get no time."""

    def of_seconds(name: str) -> None:
        convert = getattr(module, name)
        setattr(module, name, lambda seconds=None: convert(_present(clock, seconds)))

    for name in ("localtime", "gmtime", "ctime"):
        of_seconds(name)
    strftime, asctime, localtime = module.strftime, module.asctime, module.localtime
    module.strftime = lambda format, *when: strftime(format, *(when or (localtime(),)))
    module.asctime = lambda *when: asctime(*(when or (localtime(),)))


def _present(clock: Clock, seconds: float | None) -> float:
    return clock.wall() // 10**9 if seconds is None else seconds  # 0.999999999 s is not the next


def _install_clock_ids(module: Any, clock: Clock) -> None:
    """`clock_gettime` tells virtual time by the clocks of the system, but not by those of CPUs."""
    ids = {"CLOCK_REALTIME": clock.wall, "CLOCK_TAI": clock.wall, "CLOCK_MONOTONIC": clock.steady,
           "CLOCK_MONOTONIC_RAW": clock.steady, "CLOCK_BOOTTIME": clock.steady,
           "CLOCK_UPTIME": clock.steady, "CLOCK_UPTIME_RAW": clock.steady}  # fmt: skip
    read = {getattr(module, name): ids[name] for name in ids if hasattr(module, name)}
    if sys.platform == "linux":
        read |= {clk_id: getattr(clock, kind) for clk_id, kind in COARSE.items()}
    real_ns = getattr(module, "clock_gettime_ns", None)
    if real_ns is None:  # Windows
        return

    def clock_gettime_ns(clk_id: int) -> int:
        return read[clk_id]() if clk_id in read else real_ns(clk_id)

    def refused(clk_id: int, time: float) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    module.clock_settime = module.clock_settime_ns = refused  # the machine's clock is not ours
    module.clock_gettime_ns = clock_gettime_ns
    module.clock_gettime = lambda clk_id: clock_gettime_ns(clk_id) / 1e9


def _install_times(clock: Clock) -> None:
    """Let `os.times` tell, beside the CPU times, how much virtual time has gone by."""
    real = os.times
    module: Any = os
    module.times = lambda: os.times_result((*real()[:4], clock.steady() / 1e9))


def _install_datetime(clock: Clock) -> None:
    """`datetime` and `uuid` are written in C: time_machine replaces their clock there."""
    traveller: Any = time_machine.travel(0, tick=False).start()
    traveller.time_ns = clock.wall


def _sleep(kernel: Kernel, seconds: float) -> None:
    if not isinstance(seconds, float):
        seconds = operator.index(seconds)  # or a TypeError, as Python's
    if seconds < 0:
        raise ValueError("sleep length must be non-negative")
    kernel.sleep(seconds)


class IntervalTimer:
    """`signal.setitimer(ITIMER_REAL)` and `signal.alarm`: SIGALRM comes at a virtual time.

    As in Python, its handler runs in the main thread, which goes on waiting afterwards unless the
    handler raises.
    """

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._main: VirtualThread = kernel.me()  # the main thread installs it
        self._due: int | None = None  # [ns]
        self._interval = 0  # [ns]
        self._generation = 0

    def install(self) -> None:
        """Take the place of the timers of the system."""
        module: Any = signal
        if not hasattr(module, "setitimer"):  # Windows
            return
        real_set, real_get = module.setitimer, module.getitimer

        def setitimer(which: int, seconds: float, interval: float = 0.0) -> tuple[float, float]:
            if which != signal.ITIMER_REAL:
                return tuple(real_set(which, seconds, interval))
            if seconds < 0 or interval < 0:
                raise module.ItimerError(22, "Invalid argument")
            return self.set(seconds, interval)

        def getitimer(which: int) -> tuple[float, float]:
            return self.left() if which == signal.ITIMER_REAL else tuple(real_get(which))

        module.setitimer, module.getitimer = setitimer, getitimer
        module.alarm = lambda seconds: round(self.set(float(seconds), 0.0)[0])
        module.pause = lambda: self._kernel.park_once() and None

    def left(self) -> tuple[float, float]:
        """Return the time until SIGALRM comes, and the interval [s]; zeros if it does not."""
        if self._due is None:
            return 0.0, 0.0
        return (self._due - self._kernel.present) / 1e9, self._interval / 1e9

    def set(self, seconds: float, interval: float) -> tuple[float, float]:
        """Start or (with 0) stop the timer; return what was left of it."""
        before = self.left()
        self._generation += 1
        self._interval = round(interval * 1e9)
        self._due = None
        if seconds > 0:
            self._arm(self._kernel.after(seconds))
        return before

    def _arm(self, due: int) -> None:
        self._due = due
        generation = self._generation
        self._kernel.call_at(due, lambda: self._ring(generation))

    def _ring(self, generation: int) -> None:
        if generation != self._generation:
            return
        self._due = None
        if self._interval:
            self._arm(self._kernel.now + self._interval)
        self._kernel.interrupt(self._main, _alarm)


def _alarm() -> None:
    """Call the process's handler of SIGALRM."""
    handler: Any = signal.getsignal(signal.SIGALRM)
    if callable(handler):
        handler(signal.SIGALRM, sys._getframe(1))
    elif handler == signal.SIG_DFL:
        os._exit(128 + signal.SIGALRM)  # as the shell tells of a process that SIGALRM has ended
