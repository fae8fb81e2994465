"""How long the threads of a process waited for a CPU: what a busy machine took from them."""

from __future__ import annotations

import contextlib
from pathlib import Path


class RunQueue:
    """The waiting times of one process, as Linux counts them (/proc/PID/task/TID/schedstat)."""

    def __init__(self, pid: int) -> None:
        self._tasks = Path(f"/proc/{pid}/task")
        self._known: dict[str, int] = {}  # thread: [ns] until now

    def worst(self) -> float:
        """Return how long the worst-off thread has waited since the last call [s].

        0 where the kernel doesn't count, and for a process that is gone.
        """
        worst, now = 0, {}
        with contextlib.suppress(OSError):
            for thread in self._tasks.iterdir():
                with contextlib.suppress(OSError, IndexError, ValueError):
                    waited = int((thread / "schedstat").read_text().split()[1])
                    worst = max(worst, waited - self._known.get(thread.name, waited))
                    now[thread.name] = waited
        self._known = now
        return worst / 1e9
