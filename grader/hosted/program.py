"""How a program of ours runs: one node, until the trial ends."""

from __future__ import annotations

from collections.abc import Callable

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


def spin(make: Callable[[], Node]) -> None:
    """Make the node, and spin it until the trial ends."""
    try:
        rclpy.init()
        rclpy.spin(make())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
