"""Starts the shuttle: what it sees, what it wants, and what it may do are three nodes.

    ros2 launch course_exercises robot_launch.py

    /scan ─► watcher ─ distance ─► driver ─ cmd_vel_raw ─► guard ─► /cmd_vel

All three live in the namespace /shuttle, and so do the topics between them.
"""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    # TODO(task 1): a Node(…) for each of the three programs, in the namespace shuttle.
    # TODO(task 2): remappings, so that they find /scan, one another, and /cmd_vel.
    # TODO(task 3): parameters.
    return LaunchDescription([Node(package="course_exercises", executable="watcher")])
