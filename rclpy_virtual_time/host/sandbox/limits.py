"""The limits that every process puts on itself, on any Linux; the amounts are in `amounts.py`.

The folder's limits are enforced by its file system (`workplaces.py`), or by the judge
(`rclpy_virtual_time/link/workplace.py`) where a host can't have a file system of its own.
"""

from __future__ import annotations

import contextlib
import resource
from pathlib import Path

from .amounts import MAX_ADDRESSES, MAX_FILE, MAX_MEMORY, MAX_OPEN_FILES

RESOURCE_LIMITS = {
    resource.RLIMIT_CORE: 0,
    resource.RLIMIT_FSIZE: MAX_FILE,
    resource.RLIMIT_NOFILE: MAX_OPEN_FILES,
    resource.RLIMIT_DATA: MAX_MEMORY,
    resource.RLIMIT_AS: MAX_ADDRESSES,  # much more: CUDA's libraries map gigabytes
}


def set_limits() -> None:
    """Lower the limits of this process for good."""
    for limit, value in RESOURCE_LIMITS.items():
        resource.setrlimit(limit, (value, value))


def die_first() -> None:
    """If the machine's memory runs out, let Linux end this process rather than the judge."""
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")
