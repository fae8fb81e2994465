"""A function that makes the nodes, a timer, remappings for all, and nodes that would start again.

field: all
"""

from launch import LaunchDescription
from launch.actions import GroupAction, OpaqueFunction, TimerAction
from launch_ros.actions import Node, SetRemap

PARTS = {"watcher": {}, "driver": {"cruise_speed": 0.4, "stop_distance": 0.6}}


def parts(context):
    return [
        Node(
            package="course_exercises",
            executable=name,
            namespace="shuttle",
            parameters=[given],
            respawn=True,
            respawn_delay=1.0,
        )
        for name, given in PARTS.items()
    ]


def generate_launch_description():
    guard = Node(
        package="course_exercises",
        executable="guard",
        namespace="shuttle",
        remappings=[("cmd_vel", "/cmd_vel")],
        parameters=[{"max_speed": 0.25}],
    )
    renamed = [SetRemap("scan", "/scan"), SetRemap("cmd_vel", "cmd_vel_raw")]
    return LaunchDescription(
        [
            TimerAction(period=0.5, actions=[guard]),
            GroupAction([*renamed, OpaqueFunction(function=parts)]),
        ]
    )
