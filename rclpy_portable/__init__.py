"""The real rclpy on a machine without ROS: its own Python, over a native half written in Python.

`activate()` lets this process import `rclpy` and the common interfaces. All nodes of the process
hear each other; nobody outside of it does.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from . import unpacking

DISTRO = "jazzy"


def activate(tell: Callable[[str], None] = lambda _: None) -> Path:
    """Let `import rclpy` find this runtime; return the folder from which it comes.

    Raises wheels.DownloadFailed: rclpy's Python is not unpacked yet and can't be had.
    """
    folder = unpacking.folder(tell)
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    return folder
