"""How long the threads of a process waited for a CPU: what a busy machine took from them.

Linux counts it (/proc/PID/task/TID/schedstat), but some kernels (6.18 does) count sleeps too,
now and then, from falling asleep until being woken. So a wait only counts as far as the thread was
also *seen* waiting: in state R, without getting on. What the process's own threads take from one
another is no fault of the machine's, and does not count.
"""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Callable
from typing import NamedTuple

from rclpy_virtual_time.link.real_clock import real_clock

LOOK_EVERY = 0.01  # [s] at most


class _Counted(NamedTuple):
    """What the kernel says of a thread."""

    ran: int  # [ns]
    waited: int  # [ns]


class RunQueue:
    """The waiting times of one process.

    Parameters
    ----------
    pid
        Of the process.
    patience
        Longest time between two calls of `look` [s]: that much waiting may go unseen. By default
        all that the kernel counts is taken for waiting, and `look` need not be called.
    clock
        A monotonic clock [s].
    processors
        How many there are; by default as many as this process may use.
    """

    def __init__(
        self,
        pid: int,
        patience: float = math.inf,
        clock: Callable[[], float] = real_clock.monotonic,
        processors: int = 0,
    ) -> None:
        self._tasks = f"/proc/{pid}/task"
        self._patience = patience
        self._clock = clock
        self._processors = processors or len(os.sched_getaffinity(0))
        self._looked = self._asked = clock()
        self._ready: dict[str, int] = {}  # thread that was ready at the last look: had run [ns]
        self._known: dict[str, _Counted] = {}  # by thread
        self._seen: dict[str, float] = {}  # thread: [s] seen in the wait that it is in

    def look(self) -> None:
        """See which threads would run if they could."""
        now = self._clock()
        since = now - self._looked
        if since < LOOK_EVERY:
            return
        self._looked = now
        before, self._ready = self._ready, {}
        for thread in self._known:
            with contextlib.suppress(OSError, IndexError, ValueError):
                if _state(f"{self._tasks}/{thread}/stat") == b"R":
                    self._ready[thread] = self._counted(thread).ran
        # a thread that was ready at both looks and has not run in between has waited
        ran = {t: (self._ready[t] - before[t]) / 1e9 for t in self._ready if t in before}
        others = self._others(sum(ran.values()), since)
        for thread, seconds in ran.items():
            waited = max(0.0, since - seconds) * others
            self._seen[thread] = self._seen.get(thread, 0.0) + waited

    def worst(self, *, unseen_too: bool = False) -> float:
        """Return how long the worst-off thread waited, in waits that ended since the last call [s].

        0 where the kernel doesn't count, and for a process that is gone. With `unseen_too` a wait
        counts in full, though it was not seen: for a process that behaved as if it had waited.
        """
        waits, now = {}, {}
        since, self._asked = self._clock() - self._asked, self._clock()
        with contextlib.suppress(OSError), os.scandir(self._tasks) as tasks:
            for thread in (task.name for task in tasks):
                with contextlib.suppress(OSError, IndexError, ValueError):
                    now[thread] = found = self._counted(thread)
                    waited = (found.waited - self._known.get(thread, found).waited) / 1e9
                    if waited:  # the kernel counts a wait when it is over
                        seen = self._seen.pop(thread, 0.0) + self._patience
                        waits[thread] = waited if unseen_too else min(waited, seen)
        used = sum(now[t].ran - self._known[t].ran for t in now if t in self._known) / 1e9
        self._known = now
        self._seen = {thread: seen for thread, seen in self._seen.items() if thread in now}
        return max(waits.values(), default=0.0) * (self._others(used, since) if unseen_too else 1.0)

    def pending(self) -> float:
        """Return the longest wait that has not ended, as far as it was seen [s]."""
        return max(self._seen.values(), default=0.0)

    def _others(self, used: float, since: float) -> float:
        """Return which part of the processors the process itself did not take (0 to 1)."""
        return max(0.0, 1.0 - used / since / self._processors) if since else 1.0

    def _counted(self, thread: str) -> _Counted:
        ran, waited, _ = _read(f"{self._tasks}/{thread}/schedstat").split()
        return _Counted(int(ran), int(waited))


def is_ready(pid: int) -> bool:
    """Return whether a thread of this process runs, or would if it got a CPU or its disk's data."""
    with contextlib.suppress(OSError), os.scandir(f"/proc/{pid}/task") as tasks:
        for thread in tasks:
            with contextlib.suppress(OSError, IndexError):
                if _state(f"{thread.path}/stat") in (b"R", b"D"):
                    return True
    return False


def _state(stat: str) -> bytes:
    """Return the state of a thread (proc_pid_stat(5)); its name, before it, may be anything."""
    return _read(stat).rpartition(b")")[2].split()[0]


def _read(path: str) -> bytes:
    """Return a file of /proc: hundreds are read each second, beside programs that are on time."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        return os.read(descriptor, 4096)
    finally:
        os.close(descriptor)
