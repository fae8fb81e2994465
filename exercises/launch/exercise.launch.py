"""Start an exercise: the mock robot, your node or nodes, their parameters, and RViz if you like.

    ros2 launch course_exercises exercise.launch.py exercise:=NAME rviz:=true

The robot's own arguments (lidar, rate, seed, …; see sim.launch.py) can be given here too.
"""

import tomllib
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

SHARE = Path(get_package_share_directory("course_exercises"))
EXERCISES = {  # what `exercise.toml` says of each; its table `launch` has what differs
    path.parent.name: tomllib.loads(path.read_text("utf-8"))
    for path in sorted(SHARE.glob("*/exercise.toml"))
}
SCENARIO = "demo_store"  # with lidar and odometry, so that RViz has a frame to show things in
SWITCHES = {  # argument: its default, and what it means
    "use_sim_time": ("false", "the nodes' time is the robot's /clock, which is published then"),
    "mock": ("true", "start the mock robot; false: a real one is there"),
    "rviz": ("false", "start RViz"),
}


def exercise(context: LaunchContext, *_: object) -> list[IncludeLaunchDescription | Node]:
    """Return the robot, the exercise's nodes or its own launch file, and RViz."""
    name = LaunchConfiguration("exercise").perform(context)
    sim_time = {"use_sim_time": LaunchConfiguration("use_sim_time").perform(context) == "true"}
    parameters = [*parameter_file(context, name), sim_time]
    nodes = [
        Node(
            package="course_exercises",
            executable=program,
            name=node or None,
            parameters=parameters,
            output="screen",
        )
        for program, node in programs(name)
    ]
    own = [file for file in EXERCISES[name]["files"] if file.endswith("launch.py")]
    if own:
        source = PythonLaunchDescriptionSource(str(SHARE / name / own[0]))
        given = {"use_sim_time": LaunchConfiguration("use_sim_time")}
        nodes = [IncludeLaunchDescription(source, launch_arguments=given.items())]
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(SHARE / "rviz" / "course.rviz")],
        parameters=[sim_time],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    return [mock_robot(context, name), *nodes, rviz]


def programs(exercise: str) -> list[tuple[str, str]]:
    """Return its programs, each with the name that its node gets; empty: its own."""
    about = EXERCISES[exercise]
    nodes = dict(about.get("launch", {}).get("nodes", []))
    names = about.get("launch", {}).get("programs") or [Path(file).stem for file in about["files"]]
    return [(program, node) for program in names for node in nodes.get(program, [""])]


def mock_robot(context: LaunchContext, name: str) -> IncludeLaunchDescription:
    """Return the robot in the scenario that was asked for, or in the exercise's."""
    launch = Path(get_package_share_directory("course_sim")) / "launch" / "sim.launch.py"
    asked = LaunchConfiguration("scenario").perform(context)
    scenario = asked or EXERCISES[name].get("launch", {}).get("scenario", SCENARIO)
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(launch)),
        launch_arguments={
            "scenario": scenario,
            "clock": LaunchConfiguration("use_sim_time").perform(context),
        }.items(),
        condition=IfCondition(LaunchConfiguration("mock")),
    )


def parameter_file(context: LaunchContext, name: str) -> list[str]:
    """Return the file that was asked for, or the exercise's; none if it has no parameters.

    Raises
    ------
    FileNotFoundError
        The file that was asked for is not there.
    """
    asked = LaunchConfiguration("params").perform(context)
    file = Path(asked) if asked else SHARE / "config" / f"{name}.yaml"
    if asked and not file.is_file():
        raise FileNotFoundError(f"params:={asked}: no such file, seen from {Path.cwd()}")
    return [str(file)] if file.is_file() else []


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and what is made of them."""
    arguments = [
        DeclareLaunchArgument(
            "exercise", choices=sorted(EXERCISES), description="whose nodes are started"
        ),
        DeclareLaunchArgument(
            "scenario", default_value="", description="of the mock robot; empty: the exercise's"
        ),
        DeclareLaunchArgument(
            "params", default_value="", description="parameter file; empty: the exercise's"
        ),
    ]
    arguments += [
        DeclareLaunchArgument(
            name, default_value=default, choices=["true", "false"], description=meaning
        )
        for name, (default, meaning) in SWITCHES.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=exercise)])
