"""How much a host may use: the limits that every process puts on itself, on any Linux."""

from __future__ import annotations

import resource

MAX_FILE = 64 * 1024 * 1024  # [bytes] of one file
MAX_DESCRIPTORS = 256
MAX_MEMORY = 4 * 1024 * 1024 * 1024  # [bytes] address space: numeric libraries map much
RESOURCE_LIMITS = {
    resource.RLIMIT_CORE: 0,
    resource.RLIMIT_FSIZE: MAX_FILE,
    resource.RLIMIT_NOFILE: MAX_DESCRIPTORS,
    resource.RLIMIT_AS: MAX_MEMORY,
}


def set_limits() -> None:
    """Lower the limits of this process for good."""
    for limit, value in RESOURCE_LIMITS.items():
        resource.setrlimit(limit, (value, value))
