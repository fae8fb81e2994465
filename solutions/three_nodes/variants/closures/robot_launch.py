"""Full names everywhere, in the launch file and in three programs without a class.

field: all
"""

from launch import LaunchDescription
from launch_ros.actions import Node

TOPICS = [
    ("scan", "/scan"),
    ("distance", "/shuttle/distance"),
    ("cmd_vel_raw", "/shuttle/cmd_vel_raw"),
]
COMMANDS = {"driver": "/shuttle/cmd_vel_raw", "guard": "/cmd_vel"}
NUMBERS = {"driver": {"cruise_speed": 0.4, "stop_distance": 0.6}, "guard": {"max_speed": 0.25}}


def generate_launch_description():
    started = LaunchDescription()
    for program in ("guard", "driver", "watcher"):
        command = [("cmd_vel", COMMANDS[program])] if program in COMMANDS else []
        started.add_action(
            Node(
                package="course_exercises",
                executable=program,
                name=program,
                namespace="/shuttle",
                parameters=[NUMBERS.get(program, {})],
                remappings=TOPICS + command,
            )
        )
    return started
