"""Trials in real time share the machine, until one of them needs it for itself."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

MOST = 64  # trials at once: more than ever run


class TrialLock:
    """Trials hold it together; one that was disturbed holds it alone, and nobody overtakes it."""

    def __init__(self) -> None:
        self._places = threading.Semaphore(MOST)
        self.entering = threading.Lock()

    @contextlib.contextmanager
    def held(self, *, alone: bool) -> Iterator[None]:
        """Hold it with others, or alone."""
        places = MOST if alone else 1
        with self.entering:
            for _ in range(places):
                self._places.acquire()
        try:
            yield
        finally:
            self._places.release(places)


TRIAL_LOCK = TrialLock()  # of this process
