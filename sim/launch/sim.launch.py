"""Start the mock robot: `ros2 launch course_sim sim.launch.py scenario:=avoid_cart lidar:=lds01`.

Each argument is the option of that name of `ros2 run course_sim mock_robot`; one that is empty is
not passed on.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

VALUES = {  # argument: its default, and what it means
    "scenario": ("demo_wall", "name of a scenario: the world, the robot's start, faults, a script"),
    "lidar": ("", "lidar profile: default, lds01, lds02 or wide; empty: the scenario's"),
    "rate": ("", "scenario seconds in a second; other than 1.0 only with clock:=true"),
    "seed": ("", "of start, clutter and noise; empty: the scenario's"),
    "duration": ("", "the robot ends after this scenario time [s]; empty: at Ctrl-C"),
    "record": ("", "folder of a new rosbag2 recording; empty: none"),
}
SWITCHES = {
    "clock": "send /clock, for nodes with use_sim_time",
    "once": "the robot ends after the scenario's own duration",
    "wait": "time begins when somebody subscribes to the robot",
}
FOXGLOVE = "a server for Foxglove: false, true (its usual port), or a port"


def robot(context: LaunchContext, *_: object) -> list[Node]:
    """Return the robot with its options; when it ends, the launch ends."""
    given = {
        name: LaunchConfiguration(name).perform(context)
        for name in (*VALUES, *SWITCHES, "foxglove")
    }
    options = [word for name in VALUES if given[name] for word in (f"--{name}", given[name])]
    options += [f"--{name}" for name in SWITCHES if given[name] == "true"]
    if given["foxglove"] != "false":
        port = [] if given["foxglove"] == "true" else [given["foxglove"]]
        options += ["--foxglove", *port]
    return [
        Node(
            package="course_sim",
            executable="mock_robot",
            arguments=options,
            output="screen",
            on_exit=Shutdown(reason="the robot has ended"),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the robot that they describe."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=meaning)
        for name, (default, meaning) in VALUES.items()
    ]
    arguments += [
        DeclareLaunchArgument(
            name, default_value="false", choices=["true", "false"], description=meaning
        )
        for name, meaning in SWITCHES.items()
    ]
    arguments.append(DeclareLaunchArgument("foxglove", default_value="false", description=FOXGLOVE))
    return LaunchDescription([*arguments, OpaqueFunction(function=robot)])
