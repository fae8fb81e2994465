"""A function that makes the nodes, a timer, remappings for all, and nodes that would start again.

field: all
"""

from launch import LaunchDescription
from launch.actions import OpaqueFunction, TimerAction
from launch_ros.actions import Node, SetRemap

WATCHER = {"executable": "watcher"}
DRIVER = {"executable": "driver", "parameters": [{"cruise_speed": 0.4, "stop_distance": 0.6}]}
GUARD = {"executable": "guard", "parameters": [{"max_speed": 0.25}]}


def node(**given):
    return Node(package="course_exercises", namespace="shuttle", respawn=True, **given)


def generate_launch_description():
    guard = node(**GUARD, remappings=[("cmd_vel", "/cmd_vel")])
    renamed = [SetRemap("scan", "/scan"), SetRemap("cmd_vel", "cmd_vel_raw")]
    others = OpaqueFunction(function=lambda context: [node(**WATCHER), node(**DRIVER)])
    return LaunchDescription([TimerAction(period=0.5, actions=[guard]), *renamed, others])
