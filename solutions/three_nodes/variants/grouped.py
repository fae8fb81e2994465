"""A group with a pushed namespace, launch arguments, and parameters set for all.

field: all
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, PushRosNamespace, SetParameter

MINE = {"package": "course_exercises", "output": "screen"}


def generate_launch_description():
    limit = LaunchConfiguration("limit")
    return LaunchDescription(
        [
            DeclareLaunchArgument("limit", default_value="0.25"),
            GroupAction(
                [
                    PushRosNamespace("shuttle"),
                    SetParameter("stop_distance", 0.6),
                    Node(executable="watcher", remappings=[("scan", "/scan")], **MINE),
                    Node(
                        executable="guard",
                        parameters=[{"max_speed": limit}],
                        remappings=[("cmd_vel", "/cmd_vel")],
                        **MINE,
                    ),
                    Node(
                        executable="driver",
                        remappings=[("cmd_vel", "cmd_vel_raw")],
                        parameters=[{"cruise_speed": 0.4}],
                        **MINE,
                    ),
                ]
            ),
        ]
    )
