"""Trials in real time that run side by side, and one that may not have company."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

WHOLE = 1_000  # trials: as many as there never are


class TrialLock:
    """Trials that run at the same time; one that was disturbed runs again with nobody beside it."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._inside = 0
        self._waiting_alone = 0

    @contextlib.contextmanager
    def held(self, *, alone: bool) -> Iterator[None]:
        """Be one of the trials, or the only one."""
        with self._changed:
            self._waiting_alone += alone
            self._changed.wait_for(lambda: self._may_enter(alone))
            self._waiting_alone -= alone
            self._inside += WHOLE if alone else 1
        try:
            yield
        finally:
            with self._changed:
                self._inside -= WHOLE if alone else 1
                self._changed.notify_all()

    @property
    def exclusive_wanted(self) -> bool:
        """One that wants no company waits for the others to leave."""
        return self._waiting_alone > 0

    def _may_enter(self, alone: bool) -> bool:
        if alone:
            return self._inside == 0
        return self._inside < WHOLE and not self.exclusive_wanted


TRIAL_LOCK = TrialLock()  # of this process
