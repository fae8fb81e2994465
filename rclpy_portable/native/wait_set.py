"""Waiting for handles to become ready."""

from __future__ import annotations

from functools import partialmethod
from typing import TYPE_CHECKING, Any

from . import machine
from .handles import Destroyable

if TYPE_CHECKING:
    from .context import Context

KINDS = ("subscription", "guard_condition", "timer", "client", "service", "event")


class GuardCondition(Destroyable):
    """Something that an executor waits for and anybody can trigger."""

    def __init__(self, _context: Context) -> None:
        self.triggered = False

    def trigger_guard_condition(self) -> None:
        """Let it be ready, once."""
        self.triggered = True
        machine.changed()


class WaitSet(Destroyable):
    """Handles to wait for; the numbers that rclpy announces are not needed."""

    def __init__(self, *_numbers_and_context: Any) -> None:
        self._all: dict[str, list[Any]] = {kind: [] for kind in KINDS}
        self._ready: dict[str, list[bool]] = {kind: [] for kind in KINDS}

    def clear_entities(self) -> None:
        """Forget all handles."""
        for kind in KINDS:
            self._all[kind], self._ready[kind] = [], []

    def _add(self, kind: str, handle: Any) -> int:
        self._all[kind].append(handle)
        return len(self._all[kind]) - 1

    # return the handle's index among those of its kind
    add_subscription = partialmethod(_add, "subscription")
    add_guard_condition = partialmethod(_add, "guard_condition")
    add_timer = partialmethod(_add, "timer")
    add_client = partialmethod(_add, "client")
    add_service = partialmethod(_add, "service")
    add_event = partialmethod(_add, "event")

    def is_ready(self, kind: str, index: int) -> bool:
        """Return whether a handle was ready when the last wait ended."""
        return self._ready[kind][index]

    def get_ready_entities(self, kind: str) -> list[int]:
        """Return the pointers of the handles that were ready when the last wait ended."""
        both = zip(self._all[kind], self._ready[kind], strict=True)
        return [handle.pointer for handle, ready in both if ready]

    def wait(self, timeout: int) -> None:
        """Wait until a handle is ready, for at most `timeout` [ns]; negative: for ever."""
        if self._look() or timeout == 0:
            return
        end = None if timeout < 0 else machine.wall_ns() + timeout
        machine.wait_until(self._look, lambda: self._remaining(end))
        self._look()

    def _look(self) -> bool:
        found = False
        for kind, handles in self._all.items():
            if kind == "guard_condition":
                ready = [handle.triggered for handle in handles]
                for handle in handles:
                    handle.triggered = False
                kept = self._ready[kind]  # a second look must not take back the first
                if len(kept) == len(ready):
                    ready = [a or b for a, b in zip(ready, kept, strict=True)]
            else:
                ready = [handle.ready for handle in handles]
            self._ready[kind] = ready
            found = found or any(ready)
        return found

    def _remaining(self, end: int | None) -> float | None:
        """Return how long nothing can happen by itself [s]; None: for ever."""
        left = [] if end is None else [end - machine.wall_ns()]
        timers = (timer.time_until_next_call() for timer in self._all["timer"])
        left += [max(1, ns) for ns in timers if ns is not None]
        due = (event.due() for event in self._all["event"])
        left += [max(1, at - machine.wall_ns()) for at in due if at is not None]
        return min(left) / 1e9 if left else None
