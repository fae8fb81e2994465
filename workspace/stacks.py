"""Threads in the page: each is a stack of its own, and the browser changes between them (JSPI).

There Python has one thread. But a stack may wait for a promise while others run, and one thread at
a time is all that the kernel of virtual time wants: its gates are promises here, and a new thread
is a call that may wait (web/worker.js). Locks, queues and executors are built on those two.

The judge waits on a stack of its own for the end of a trial. What waits then is never woken: the
next copy of the memory knows nothing of it.
"""

from __future__ import annotations

import _thread
import itertools
import sys
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any, NoReturn, Protocol

from rclpy_virtual_time.host.imports import host


class Browser(Protocol):
    """What the worker offers."""

    def begin(self, number: int) -> None:
        """Call `Stacks.run_body` on a new stack, once the present one waits or ends."""

    def wait(self, number: int) -> None:
        """Wait on this stack until somebody wakes the number."""

    def wake(self, number: int) -> None:
        """Let a stack go on, once the present one waits or ends."""


class Stacks:
    """All stacks of a process."""

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self._main = self._current = _thread.get_ident()  # the number of Python's own thread
        self._numbers = itertools.count(self._main + 1)
        self._bodies: dict[int, Callable[[], object]] = {}
        self._ends: dict[int, Any] = {}  # what opens when a thread ends, as `join` wants it
        self._frames: dict[int, FrameType | None] = {}  # the student's, of those that wait
        self._over = Gate(self)

    def install(self) -> None:
        """Put them under Python's threads. Before the kernel is imported."""
        module: Any = threading
        _thread.start_new_thread = module._start_new_thread = self._start_new_thread
        _thread.get_ident = threading.get_ident = lambda: self._current
        module._set_sentinel = self._set_sentinel  # until Python 3.12
        module._ThreadHandle, module._start_joinable_thread = Handle, self._start_joinable_thread
        sys._current_frames = self._current_frames  # type: ignore[assignment]

    def run(self, body: Callable[[], object]) -> None:
        """Run a trial's program on a stack of its own until it is over."""
        raised: list[BaseException] = []

        def whole() -> None:
            try:
                body()
            except BaseException as error:
                raised.append(error)
            self._over.release()

        self._over.acquire()
        self._begin(self._main, whole)
        self._over.acquire()
        if raised:
            raise raised[0]

    def leave(self) -> NoReturn:
        """End a trial: its programs never go on."""
        self._over.release()
        self.wait()
        raise AssertionError("nobody knows the number of this wait")

    def wait(self, tell: Callable[[int], object] = lambda _: None) -> None:
        """Wait on this stack for a number that `tell` is told."""
        number, current = next(self._numbers), self._current
        self._frames[current] = _students(sys._getframe(1))
        tell(number)
        self._browser.wait(number)
        self._current = current
        del self._frames[current]

    def wake(self, number: int) -> None:
        """Let who waits for a number go on."""
        self._browser.wake(number)

    def run_body(self, number: int) -> None:
        """Do what a new stack is for."""
        self._current = number
        try:
            self._bodies.pop(number)()
        finally:
            end = self._ends.pop(number, None)
            if end is not None and end.locked():
                end.release()

    def _begin(self, number: int, body: Callable[[], object]) -> None:
        self._bodies[number] = body
        self._browser.begin(number)

    def _start_new_thread(
        self, function: Callable[..., object], args: tuple[Any, ...] = (), kwargs: Any = None
    ) -> int:
        number = next(self._numbers)
        self._begin(number, lambda: function(*args, **(kwargs or {})))
        return number

    def _start_joinable_thread(
        self, function: Callable[[], object], handle: Handle, daemon: bool
    ) -> None:
        number = self._start_new_thread(function)
        self._ends[number] = handle.begin()

    def _current_frames(self) -> dict[int, FrameType | None]:
        """Return one frame of each thread; Python would look into stacks that lie elsewhere now."""
        return {**self._frames, self._current: sys._getframe(1)}

    def _set_sentinel(self) -> Any:
        self._ends[self._current] = end = threading.Lock()
        return end


class Handle:
    """What a `Thread` knows of its end, from Python 3.13 on."""

    def __init__(self) -> None:
        self._end = threading.Lock()

    def begin(self) -> Any:
        """Return the lock that opens at the end."""
        self._end.acquire()
        return self._end

    def is_done(self) -> bool:
        """Return whether the thread has ended."""
        return not self._end.locked()

    def join(self, timeout: float | None = None) -> None:
        """Wait for the end."""
        if self._end.acquire(timeout=-1 if timeout is None else timeout):
            self._end.release()


class Gate:
    """A lock that one stack holds and one waits for."""

    def __init__(self, stacks: Stacks) -> None:
        self._stacks = stacks
        self._held = False
        self._waiting = 0

    def acquire(self) -> None:
        """Take it; wait for it if it is held."""
        if self._held:
            self._stacks.wait(self._note)
        self._held = True

    def release(self) -> None:
        """Give it to who waits, or leave it open."""
        self._held = False
        if self._waiting:
            number, self._waiting = self._waiting, 0
            self._stacks.wake(number)

    def _note(self, number: int) -> None:
        self._waiting = number


def _students(frame: FrameType | None) -> FrameType | None:
    while frame is not None and not host.is_beside(frame.f_code.co_filename):
        frame = frame.f_back
    return frame
