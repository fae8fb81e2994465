"""What this computer is: are there wheels of ROS 2 for it?

It needs nothing that only Linux has.
"""

from __future__ import annotations

import platform
import sys

WHEELS_BEFORE = (3, 15)  # a Python for which there are none any more


def is_tried() -> bool:
    """Return whether all of this has been run on such a system: Linux on x86_64."""
    return sys.platform == "linux" and platform.machine() in ("x86_64", "AMD64")


def has_ros_wheels() -> bool:
    """Return whether PyPI has the real ROS 2 for this system and this Python."""
    return is_tried() and sys.version_info < WHEELS_BEFORE


def name() -> str:
    """Say what this is: Python, system, processor."""
    return f"{platform.python_version()} on {platform.platform(terse=True)} ({platform.machine()})"
