"""Put the kernel under Python: everything on which Python code can block becomes a parking place.

All blocking comes down to five things: thread locks (Condition, Event, Semaphore, Queue, Future
and Barrier are built on them) and `join`, `time.sleep`, SimpleQueue (written in C, used by
ThreadPoolExecutor), the wait of an rclpy executor (see ros.py), and the `select` under asyncio.
`install` must run before rclpy and the student's file are imported.
"""

from __future__ import annotations

import _thread
import collections
import multiprocessing.connection
import os
import queue
import selectors
import threading
import time
from collections.abc import Callable
from typing import Any

from .kernel import Kernel, VirtualThread, Waiters

STEADY_START = 1_000 * 10**9  # [ns] monotonic clocks start here, as on a machine up for a while
PATIENCE = 1_000  # readings of the clock at one moment, after which a busy wait costs time ...
PATIENCE_STEP = 0.001  # [s] ... namely this much
CPUS = {0, 1, 2, 3}  # MultiThreadedExecutor() takes a thread per CPU; with one it would serialise

_real_start_new_thread = _thread.start_new_thread


class Clock:
    """The virtual readings of `time`, `monotonic` and `perf_counter`."""

    def __init__(self, kernel: Kernel, epoch: int) -> None:
        self._kernel = kernel
        self._epoch = epoch
        self._moment = -1
        self._readings = 0

    def wall(self) -> int:
        """Return the time since 1970 [ns]."""
        return self._epoch + self._read()

    def steady(self) -> int:
        """Return the time since some moment in the past [ns]."""
        return STEADY_START + self._read()

    def _read(self) -> int:
        kernel = self._kernel
        if kernel.now != self._moment:
            self._moment, self._readings = kernel.now, 0
        self._readings += 1
        if self._readings > PATIENCE:  # `while time.monotonic() < end: pass` must end
            self._readings = 0
            kernel.sleep(PATIENCE_STEP)
        return kernel.now


class Lock:
    """`threading.Lock`, handed to the thread that has waited longest."""

    kernel: Kernel

    def __init__(self) -> None:
        self._held = False
        self._waiters: Waiters = collections.deque()

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take the lock; False if it could not be had."""
        if not self._held:
            self._held = True
            return True
        if not blocking or timeout == 0:
            return False
        kernel = self.kernel
        return kernel.park(None if timeout < 0 else kernel.after(timeout), self._waiters)

    def release(self) -> None:
        """Hand the lock on, or leave it free."""
        if not self._held:
            raise RuntimeError("release unlocked lock")
        while self._waiters:
            if self.kernel.wake(self._waiters.popleft()):
                return
        self._held = False

    def locked(self) -> bool:
        """Tell whether somebody holds the lock."""
        return self._held

    def _at_fork_reinit(self) -> None:
        self._held = False
        self._waiters.clear()

    __enter__ = acquire

    def __exit__(self, *_: object) -> None:
        self.release()


def install(kernel: Kernel, epoch: int) -> None:
    """Replace the blocking primitives of this process by those of `kernel`."""
    _install_threads(kernel)
    _install_locks(kernel)
    _install_time(kernel, Clock(kernel, epoch))
    _install_select(kernel)
    os.sched_getaffinity = lambda _pid: CPUS


def _run(kernel: Kernel, thread: VirtualThread, body: Callable[[], object]) -> None:
    kernel.enter(thread)
    try:
        body()
    finally:
        kernel.leave(thread)


def _install_threads(kernel: Kernel) -> None:
    cls: Any = threading.Thread
    start, bootstrap, join = cls.start, cls._bootstrap, cls.join

    def virtual_start(self: Any) -> None:
        self._virtual = kernel.add()
        start(self)

    def virtual_bootstrap(self: Any) -> None:
        _run(kernel, self._virtual, lambda: bootstrap(self))

    def virtual_join(self: Any, timeout: float | None = None) -> None:
        thread = getattr(self, "_virtual", None)
        if thread is not None and not thread.done:
            deadline = None if timeout is None else kernel.after(timeout)
            if self is threading.current_thread():
                raise RuntimeError("cannot join current thread")
            if not kernel.park(deadline, thread.joiners):
                return
        join(self)

    def virtual_is_alive(self: Any) -> bool:
        thread = getattr(self, "_virtual", None)
        return bool(self._started.is_set()) and not (thread is not None and thread.done)

    def virtual_start_new_thread(
        function: Callable[..., object], args: tuple[Any, ...] = (), kwargs: Any = None
    ) -> int:
        thread = kernel.add()
        keywords = kwargs or {}
        return _real_start_new_thread(_run, (kernel, thread, lambda: function(*args, **keywords)))

    cls.start, cls.join, cls.is_alive = virtual_start, virtual_join, virtual_is_alive
    cls._bootstrap = virtual_bootstrap
    _thread.start_new_thread = virtual_start_new_thread


def _install_locks(kernel: Kernel) -> None:
    Lock.kernel = kernel
    module: Any = threading
    module._allocate_lock = module.Lock = Lock
    _thread.allocate_lock = Lock  # type: ignore[assignment]
    module._CRLock = None  # RLock() is then the Python one, made of a Lock
    queue.SimpleQueue = queue._PySimpleQueue  # type: ignore[attr-defined,misc]


def _install_time(kernel: Kernel, clock: Clock) -> None:
    module: Any = time
    module.sleep = lambda seconds: _sleep(kernel, seconds)
    module.time_ns, module.time = clock.wall, lambda: clock.wall() / 1e9
    for name in ("monotonic", "perf_counter"):
        setattr(module, f"{name}_ns", clock.steady)
        setattr(module, name, lambda: clock.steady() / 1e9)
    threading._time = queue.time = module.monotonic  # type: ignore[attr-defined]


def _sleep(kernel: Kernel, seconds: float) -> None:
    if seconds < 0:
        raise ValueError("sleep length must be non-negative")
    kernel.sleep(seconds)


def _install_select(kernel: Kernel) -> None:
    """Asyncio's loop waits here, and a ThreadPool (scikit-learn's n_jobs) for its pipe."""

    def virtual(select: Any) -> Any:
        def virtual_select(self: Any, timeout: float | None = None) -> list[Any]:
            deadline = None if timeout is None else kernel.after(timeout)
            return kernel.poll(self, lambda: select(self, 0) or None, deadline) or []

        return virtual_select

    cls: Any = selectors.DefaultSelector
    cls.select = virtual(cls.select)
    connection: Any = multiprocessing.connection
    poll: Any = selectors.PollSelector
    connection._WaitSelector = type("WaitSelector", (poll,), {"select": virtual(poll.select)})
