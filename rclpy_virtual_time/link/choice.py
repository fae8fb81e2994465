"""Which launcher a command takes: Linux's with the real rclpy, or the one that runs anywhere."""

from __future__ import annotations

import os
import signal
import sys
from typing import TYPE_CHECKING, Any

from rclpy_virtual_time.link.errors import NoRos
from rclpy_virtual_time.link.practice import PracticeServer
from rclpy_virtual_time.link.ros_environment import find_ros

if TYPE_CHECKING:
    from rclpy_virtual_time.link.hosts import ForkServer


def start_launcher(
    epoch: int, libraries: tuple[str, ...] = (), *, portable: bool = False, **options: Any
) -> ForkServer | PracticeServer:
    """Start a launcher.

    Parameters
    ----------
    epoch
        ROS time of a scenario's start [ns].
    libraries
        Modules that are imported before a host is asked to work.
    portable
        Take the portable runtime also where the real rclpy is.
    options
        `advice` and `workshop` of `ForkServer`.

    Raises
    ------
    NoRos
        There is neither.
    """
    if portable or why_not_linux():
        return PracticeServer(epoch, libraries=libraries, **options)
    from rclpy_virtual_time.link.hosts import ForkServer  # noqa: PLC0415

    return ForkServer(epoch, libraries=libraries, **options)


def why_not_linux(*, portable: bool = False) -> str:
    """Say why a fork server can't be used here; "" if it can. `portable`: it needs no ROS 2."""
    if not (hasattr(os, "fork") and hasattr(os, "pidfd_open") and hasattr(signal, "SIGUSR1")):
        return f"the launcher for the real rclpy is for Linux, and this is {sys.platform}"
    try:
        if not portable:
            find_ros()
    except NoRos as error:
        return str(error)
    return ""
