"""Put the kernel under Python: everything on which Python code can block becomes a parking place.

All blocking comes down to five things: thread locks (Condition, Event, Semaphore, Queue, Future
and Barrier are built on them) and `join`, `time.sleep`, SimpleQueue (written in C, used by
ThreadPoolExecutor), the wait of an rclpy executor (executors.py), and the `select` under asyncio.
`install` must run before rclpy and the student's file are imported.
"""

from __future__ import annotations

import _queue
import _thread
import collections
import functools
import os
import queue
import sys
import threading
import traceback
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from ..frames import Note
from ..imports import host, place_of
from . import clock, descriptors
from .kernel import Kernel, VirtualThread, Waiters

CPUS = {0, 1, 2, 3}  # MultiThreadedExecutor() takes a thread per CPU; with one it would serialise

_real_start_new_thread = _thread.start_new_thread


class Lock:
    """`threading.Lock`, handed to the thread that has waited longest."""

    kernel: Kernel

    def __init__(self) -> None:
        self._held = False
        self._waiters: Waiters = collections.deque()

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take the lock; False if it could not be had."""
        if not blocking and timeout != -1:
            raise ValueError("can't specify a timeout for a non-blocking call")
        if timeout < 0 and timeout != -1:
            raise ValueError("timeout value must be a non-negative number")
        if timeout > threading.TIMEOUT_MAX:
            raise OverflowError("timeout value is too large")
        if not self._held:
            self._held = True
            return True
        if not blocking or timeout == 0:
            return False
        kernel = self.kernel
        return kernel.park(None if timeout < 0 else kernel.after(timeout), self._waiters)

    acquire_lock = acquire

    def release(self) -> None:
        """Hand the lock on, or leave it free."""
        if not self._held:
            raise RuntimeError("release unlocked lock")
        while self._waiters:
            if self.kernel.wake(self._waiters.popleft()):
                return
        self._held = False

    def locked(self) -> bool:
        """Return whether a thread holds the lock."""
        return self._held

    release_lock, locked_lock = release, locked

    def __repr__(self) -> str:
        state = "locked" if self._held else "unlocked"
        return f"<{state} _thread.lock object at {id(self):#x}>"

    def _at_fork_reinit(self) -> None:
        self._held = False
        self._waiters.clear()

    def __enter__(self) -> bool:
        if self._held:
            return self.acquire()
        self._held = True
        return True

    def __exit__(self, *_: object) -> None:
        if self._held and not self._waiters:
            self._held = False
        else:
            self.release()


Lock.__module__, Lock.__name__, Lock.__qualname__ = "_thread", "lock", "lock"  # as Python's


def install(kernel: Kernel, epoch: int) -> None:
    """Replace the blocking primitives of this process by those of `kernel`."""
    _install_threads(kernel)
    _install_locks(kernel)
    clock.install(kernel, epoch)
    descriptors.install(kernel)
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
        if not self._initialized or self._started.is_set():
            start(self)  # raises RuntimeError
        _note_start(kernel)
        self._virtual = thread = kernel.add()
        try:
            start(self)
        except BaseException:
            if not self._started.is_set():
                kernel.forget(thread)
            raise

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
        if thread is None or not thread.done:
            return bool(self._started.is_set())
        join(self)  # it has nothing left to do; from now on its repr says "stopped"
        return False

    def virtual_start_new_thread(
        function: Callable[..., object], args: tuple[Any, ...] = (), kwargs: Any = None
    ) -> int:
        _note_start(kernel)
        thread = kernel.add()
        keywords = kwargs or {}

        def body() -> None:
            try:
                function(*args, **keywords)
            except SystemExit:
                pass
            except BaseException as error:
                _tell_unraisable(error, function)

        try:
            return _real_start_new_thread(_run, (kernel, thread, body))
        except BaseException:
            kernel.forget(thread)
            raise

    cls.start, cls.join, cls.is_alive = virtual_start, virtual_join, virtual_is_alive
    cls._bootstrap = virtual_bootstrap
    _thread.start_new_thread = virtual_start_new_thread


def _note_start(kernel: Kernel) -> None:
    """Note the program's line that starts a thread while the robot drives."""
    frame: Any = sys._getframe(1) if kernel.now > 0 else None
    while frame is not None and not host.is_beside(frame.f_code.co_filename):
        frame = frame.f_back
    if frame is not None:
        place = place_of(frame.f_code, frame.f_lineno)
        kernel.world.note(Note("threads", frame.f_code.co_name, place))


def _tell_unraisable(error: BaseException, function: Callable[..., object]) -> None:
    """Report an exception in a thread without a `Thread`, as Python would without `_run`."""
    trace = error.__traceback__ and error.__traceback__.tb_next
    told = "Exception ignored in thread started by"
    if sys.unraisablehook is sys.__unraisablehook__:  # it takes no arguments but Python's own
        print(f"{told}: {function!r}", file=sys.stderr)
        traceback.print_exception(type(error), error, trace)
        return
    arguments: Any = SimpleNamespace(
        exc_type=type(error), exc_value=error, exc_traceback=trace, err_msg=told, object=function
    )
    sys.unraisablehook(arguments)


def _install_locks(kernel: Kernel) -> None:
    Lock.kernel = kernel
    module: Any = threading
    module._allocate_lock = module.Lock = Lock
    _thread.allocate_lock = Lock  # type: ignore[assignment]
    futures: Any = sys.modules.get("concurrent.futures.thread")
    if futures is not None:  # a thread that starts another in any pool parks with this lock
        futures._global_shutdown_lock = Lock()
    module._CRLock = None  # RLock() is then the Python one, made of a Lock
    if hasattr(functools, "RLock"):  # until Python 3.11: the lock of cached_property
        functools.RLock = threading.RLock
    native: Any = _queue
    native.SimpleQueue = queue.SimpleQueue = queue._PySimpleQueue  # type: ignore[attr-defined,misc]
