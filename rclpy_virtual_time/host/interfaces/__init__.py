"""Packages of ROS interfaces made while a program runs, from the text of their files.

rosidl would generate Python and C, which takes a compiler. Here `classes.py` makes the Python
classes, `rclpy_portable.cdr` writes and reads them, and `native.py` shows them to rcl and Fast DDS.
"""

from .classes import define

__all__ = ["define"]
