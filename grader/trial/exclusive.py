"""Trials in real time share the machine, until one of them needs it for itself."""

from __future__ import annotations

import contextlib
import fcntl
import os
import threading
from collections.abc import Iterator

MAX_TRIALS = 64  # at once: more than ever run


class TrialLock:
    """A lock that trials share; a disturbed trial holds it alone, and no trial overtakes that.

    On a shared network a node could drive the robot of another student's trial. There, trials of
    one process run at a time: it holds this file, which no host can open.
    """

    def __init__(self) -> None:
        self._places = threading.Semaphore(MAX_TRIALS)
        self.entering = threading.Lock()
        self._leaving = threading.Lock()
        self._inside = 0
        self._machine: int | None = None  # a descriptor that holds it

    @contextlib.contextmanager
    def held(self, *, alone: bool, shared_network: bool = False) -> Iterator[None]:
        """Hold the lock with other trials, or alone."""
        places = MAX_TRIALS if alone else 1
        with self.entering:
            for _ in range(places):
                self._places.acquire()
            with self._leaving:
                if shared_network and not self._inside:
                    self._machine = os.open(__file__, os.O_RDONLY | os.O_CLOEXEC)
                    fcntl.flock(self._machine, fcntl.LOCK_EX)
                self._inside += 1
        try:
            yield
        finally:
            with self._leaving:
                self._inside -= 1
                if self._machine is not None and not self._inside:
                    os.close(self._machine)
                    self._machine = None
            self._places.release(places)


TRIAL_LOCK = TrialLock()  # of this process
