"""Which launcher a command takes: Linux's with the real rclpy, or the one that runs anywhere."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy_virtual_time.link.practice import PracticeServer
from rclpy_virtual_time.link.settings import EPOCH

if TYPE_CHECKING:
    from rclpy_virtual_time.link.hosts import ForkServer


def start_launcher(
    epoch: int = EPOCH, libraries: tuple[str, ...] = (), *, portable: bool = False, **options: Any
) -> ForkServer | PracticeServer:
    """Start a launcher.

    Raises NoRos: there is neither.

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
    """
    if portable or PracticeServer.why_needed():
        return PracticeServer(epoch, libraries=libraries, **options)
    from rclpy_virtual_time.link.hosts import ForkServer  # noqa: PLC0415

    return ForkServer(epoch, libraries=libraries, **options)
