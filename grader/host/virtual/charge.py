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

    def restart(self) -> None:
        """Forget what was used: it was the host's own work."""
        self._since = cpu_time_ns()

    def whole(self) -> int:
        """Return the whole grains used [ns], as due; what is left over stays on the meter."""
        used = cpu_time_ns() - self._since
        due = used - used % GRAIN
        self._since += due
        return due

    def rounded(self) -> int:
        """Return what was used, to the nearest grain [ns]; the meter starts anew."""
        used = cpu_time_ns() - self._since
        self.restart()
        return (used + GRAIN // 2) // GRAIN * GRAIN
