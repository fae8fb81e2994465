"""Trials in real time share the machine, until one of them needs it for itself."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

ALL = 1_000  # trials: more than ever run at once


class TrialLock:
    """A readers-writer lock: trials hold it together; one that was disturbed holds it alone."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._inside = 0
        self._waiting_alone = 0

    @contextlib.contextmanager
    def held(self, *, alone: bool) -> Iterator[None]:
        """Hold it with others, or alone."""
        with self._changed:
            self._waiting_alone += alone
            self._changed.wait_for(lambda: self._may_enter(alone))
            self._waiting_alone -= alone
            self._inside += ALL if alone else 1
        try:
            yield
        finally:
            with self._changed:
                self._inside -= ALL if alone else 1
                self._changed.notify_all()

    @property
    def exclusive_wanted(self) -> bool:
        """Somebody waits to hold it alone; nobody else may enter meanwhile."""
        return self._waiting_alone > 0

    def _may_enter(self, alone: bool) -> bool:
        if alone:
            return self._inside == 0
        return self._inside < ALL and not self.exclusive_wanted


TRIAL_LOCK = TrialLock()  # of this process
