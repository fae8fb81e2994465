"""The fixture `virtual_time`: rclpy_virtual_time/testing/plugin.py."""

from rclpy_virtual_time.testing.plugin import *  # noqa: F403

from . import FOLDER  # noqa: F401  (lets `rclpy_virtual_time` be found)
