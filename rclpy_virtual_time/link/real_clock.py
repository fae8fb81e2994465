"""The judge's clocks: the machine's own, also where a node's virtual time replaces those of `time`.

That happens in one process only with the node's; this has to be imported before. (`time_ns`, which
is replaced in C, is for trials in real time: their hosts are always other processes.)
"""

from __future__ import annotations

import time


class RealClock:
    """The functions of `time`, as they were at the start."""

    monotonic = staticmethod(time.monotonic)
    monotonic_ns = staticmethod(time.monotonic_ns)
    perf_counter = staticmethod(time.perf_counter)
    process_time = staticmethod(time.process_time)
    sleep = staticmethod(time.sleep)
    time_ns = staticmethod(time.time_ns)

    @staticmethod
    def cpu_time(pid: int) -> float:
        """Return the CPU time that a process has used [s]; nan where the system doesn't tell."""
        try:
            return time.clock_gettime(~pid << 3 | 2)  # its clock on Linux: clock_getcpuclockid(3)
        except (AttributeError, OSError):
            return float("nan")


real_clock = RealClock()
