"""What computing costs in virtual time: nothing, unless `course drive --charge-compute` asks.

Then the CPU time of the process is charged to the clock, in milliseconds: at the end of a moment,
before time goes on, and before the program reads a clock or begins to wait. It is CPU time, not
wall time, so other programs on the machine do not count; a faster CPU still gives another run.
"""

from __future__ import annotations

import time

GRAIN = 1_000_000  # [ns] time is charged in units of this

cpu_time_ns = time.process_time_ns  # of all threads; the student might replace it


class Meter:
    """The CPU time that the program has used and not yet paid for."""

    def __init__(self) -> None:
        self._since = cpu_time_ns()
        self._left = 0  # [ns] used before that

    def restart(self) -> None:
        """Leave out the CPU time after the last reading, because the host's own work took it."""
        self._since = cpu_time_ns()

    def whole(self) -> int:
        """Return the whole grains that are due [ns]; what is left over is due later."""
        used = self._used()
        self._left = used % GRAIN
        return used - self._left

    def rounded(self) -> int:
        """Return the time that is due, to the nearest grain [ns]; nothing is left over."""
        used, self._left = self._used(), 0
        return (used + GRAIN // 2) // GRAIN * GRAIN

    def _used(self) -> int:
        now = cpu_time_ns()
        used, self._since = self._left + now - self._since, now
        return used
