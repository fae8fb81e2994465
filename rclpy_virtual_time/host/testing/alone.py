"""Virtual time without a judge: time moves as far as the test's own program takes it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..virtual import kernel as kernel_module


class StandIn:
    """Replaces the bridge in tests: every endpoint is treated as connected."""

    parameters_in_use = True

    def __init__(self) -> None:
        self._asked = 0

    def waits(self) -> None:
        """Nothing waits for a node."""

    @property
    def changes(self) -> int:
        """Another number each time: endpoints may always have changed."""
        self._asked += 1
        return self._asked


class Alone(kernel_module.World):
    """The world of a kernel in which only the program acts.

    Parameters
    ----------
    kernel
        Its main thread is the calling one.
    limit
        The virtual time that the program may take [ns].
    complain
        Raises an exception with the text that it is given. It is called in the main thread, where
        that waits, if time is up or if nothing can happen any more.
    """

    def __init__(
        self, kernel: kernel_module.Kernel, limit: int, complain: Callable[[str], None]
    ) -> None:
        self.kernel = kernel
        self.until = self._limit = limit
        self.clocks: Any = None
        self.watchers: list[Callable[[], None]] = []  # called when a moment is over
        self._main = kernel.me()
        self._complain = complain
        self._moment = 0  # [ns] at which everything had settled

    def settled(self) -> None:
        """Let the watchers see what has happened at this moment."""
        self._moment = self.kernel.now
        for watch in self.watchers:
            watch()

    def moved(self) -> None:
        """Time has moved: tell the clocks."""
        self.clocks.follow()

    def exchange(self) -> None:
        """Tell the main thread that time is up, or that no thread waits for a time."""
        kernel = self.kernel
        text = (
            f"the test still runs after {self.until / 1e9:g} s of virtual time, its limit"
            if kernel.asleep
            else f"nothing can happen any more since {self._moment / 1e9:g} s: every thread waits "
            "for something, and nobody for a time"
        )
        self.until = kernel.now + self._limit  # what is cleaned up takes its time, too
        kernel.interrupt(self._main, lambda: self._complain(text))
