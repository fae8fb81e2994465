"""How long the threads of a process waited for a CPU: what a busy machine took from them.

Linux counts it (/proc/PID/task/TID/schedstat), but some kernels (6.18 does) count sleeps too,
now and then, from falling asleep until being woken. So a wait only counts as far as the thread was
also *seen* waiting: in state R.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable
from pathlib import Path

LOOK_EVERY = 0.01  # [s] at most


class RunQueue:
    """The waiting times of one process.

    Parameters
    ----------
    pid
        Of the process.
    patience
        Longest time between two calls of `look` [s]: so much waiting may go unseen. By default
        the kernel is believed, and `look` need not be called.
    clock
        A monotonic clock [s].
    """

    def __init__(
        self, pid: int, patience: float = math.inf, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._tasks = Path(f"/proc/{pid}/task")
        self._patience = patience
        self._clock = clock
        self._looked = clock()
        self._known: dict[str, int] = {}  # thread: [ns] until now
        self._seen: dict[str, float] = {}  # thread: [s] seen waiting since the last call of worst()

    def look(self) -> None:
        """See which threads would run if they could."""
        now = self._clock()
        since = now - self._looked
        if since < LOOK_EVERY:
            return
        self._looked = now
        for thread in self._known:
            with contextlib.suppress(OSError, IndexError):
                after_name = (self._tasks / thread / "stat").read_text().rpartition(")")[2]
                if after_name.split()[0] == "R":
                    self._seen[thread] = self._seen.get(thread, 0.0) + since

    def worst(self, *, believed: bool = False) -> float:
        """Return how long the worst-off thread has waited since the last call [s].

        0 where the kernel doesn't count, and for a process that is gone. If it is `believed`, its
        count is taken as it is: the process behaved as if it had waited.
        """
        worst, now = 0.0, {}
        with contextlib.suppress(OSError):
            for thread in self._tasks.iterdir():
                with contextlib.suppress(OSError, IndexError, ValueError):
                    waited = int((thread / "schedstat").read_text().split()[1])
                    counted = (waited - self._known.get(thread.name, waited)) / 1e9
                    seen = self._seen.get(thread.name, 0.0) + self._patience
                    worst = max(worst, counted if believed else min(counted, seen))
                    now[thread.name] = waited
        self._known, self._seen = now, {}
        return worst
