"""Put the kernel under waits for file descriptors: `select`, `poll`, `epoll` and `selectors`.

asyncio's loops wait there, a ThreadPool (scikit-learn's n_jobs) for its pipe, and whoever reads a
keyboard with a timeout. `install` must run before the student's file is imported.
"""

from __future__ import annotations

import select
import selectors
import subprocess
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from .kernel import Kernel

SLEEP = time.sleep  # the real one


def install(kernel: Kernel) -> None:
    """Replace what waits for file descriptors in this process."""
    poll: Any = getattr(selectors, "PollSelector", None)
    if poll is not None:  # another process, where one may be started, answers in real time
        popen: Any = subprocess
        popen._PopenSelector = type("PopenSelector", (poll,), {"select": poll.select})
        popen.time = SimpleNamespace(sleep=SLEEP)  # in the loop of `wait(timeout)`
    for name in ("EpollSelector", "KqueueSelector", "PollSelector", "SelectSelector"):
        cls: Any = getattr(selectors, name, None)
        if cls is not None:
            cls.select = _virtual_selector(kernel, cls.select)
    module: Any = select
    module.select = _virtual_select(kernel, module.select)
    for name, unit in (("poll", 1e-3), ("epoll", 1.0)):  # [s] what their timeouts count
        if hasattr(module, name):
            setattr(module, name, _polling(kernel, getattr(module, name), unit))


def _virtual_selector(kernel: Kernel, select: Any) -> Any:
    def virtual_select(self: Any, timeout: float | None = None) -> list[Any]:
        return _wait(kernel, self, lambda: select(self, 0) or None, timeout) or []

    return virtual_select


def _virtual_select(kernel: Kernel, real: Any) -> Any:
    def virtual_select(r: Any, w: Any, x: Any, timeout: float | None = None) -> Any:
        if timeout is not None and not (isinstance(timeout, int | float) and timeout >= 0):
            return real(r, w, x, timeout)  # which says what is wrong
        if timeout and not any((r, w, x)):  # a way to sleep
            kernel.sleep(timeout)
            return [], [], []
        r, w, x = list(r), list(w), list(x)
        key = tuple(map(repr, (r, w, x)))

        def look() -> Any:
            found = real(r, w, x, 0)
            return found if any(found) else None

        return _wait(kernel, key, look, timeout) or ([], [], [])

    return virtual_select


def _polling(kernel: Kernel, make: Any, unit: float) -> Any:
    """Return what makes an object of `poll` or `epoll`, in `unit`s of whose time its waits are."""

    class Polling:
        """Does as the system's object, whose type can't be inherited from."""

        def __init__(self, *arguments: Any, **keywords: Any) -> None:
            self._real = make(*arguments, **keywords)

        def poll(self, timeout: float | None = None, *most: int) -> list[tuple[int, int]]:
            if timeout is not None and not isinstance(timeout, int | float):
                return list(self._real.poll(timeout, *most))  # which says what is wrong
            seconds = None if timeout is None or timeout < 0 else timeout * unit
            return _wait(kernel, self, lambda: self._real.poll(0, *most) or None, seconds) or []

        def __enter__(self) -> Polling:
            self._real.__enter__()
            return self

        def __exit__(self, *error: object) -> None:
            self._real.__exit__(*error)

        def __getattr__(self, name: str) -> Any:
            return getattr(self._real, name)

    return Polling


def _wait(
    kernel: Kernel, key: object, look: Callable[[], Any], seconds: float | None = None
) -> Any:
    deadline = None if seconds is None else kernel.after(seconds)
    return kernel.poll(key, look, deadline)
