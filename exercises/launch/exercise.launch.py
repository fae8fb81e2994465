"""Start an exercise: the mock robot, your node or nodes, their parameters, and RViz if you like.

    ros2 launch course_exercises exercise.launch.py exercise:=goal_seeking rviz:=true

The robot's own arguments (lidar, rate, seed, …; see sim.launch.py) can be given here too.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

CLIENTS = ("navigation_client", "manipulation_client", "logging_client")
EXERCISES = {  # exercise: its programs, each with the name that its node gets ("": its own)
    "obstacle_avoidance": [("obstacle_avoidance_agent", "")],
    "ml_velocity": [("ml_velocity_controller", "")],
    "goal_seeking": [("goal_seeking_agent", "")],
    "trend_memory": [("trend_agent", "")],
    "slow_model": [("decoupled_controller", "")],
    "model_server": [("detection_server", ""), *(("detection_client", name) for name in CLIENTS)],
    "safety_supervisor": [("safety_supervisor", "")],
    "model_formats": [("policy_controller", "")],
    "latency_monitor": [("profiled_controller", "")],
}
SCENARIO = "demo_store"  # with lidar and odometry, so that RViz has a frame to show things in
SCENARIOS = {"goal_seeking": "goal_origin_to_5_3", "safety_supervisor": "demo_full_speed"}
SWITCHES = {  # argument: its default, and what it means
    "use_sim_time": ("false", "the nodes' time is the robot's /clock, which is published then"),
    "mock": ("true", "start the mock robot; false: a real one is there"),
    "rviz": ("false", "start RViz"),
}


def exercise(context: LaunchContext, *_: object) -> list[IncludeLaunchDescription | Node]:
    """Return the robot, the exercise's nodes, and RViz."""
    name = LaunchConfiguration("exercise").perform(context)
    share = Path(get_package_share_directory("course_exercises"))
    sim_time = {"use_sim_time": LaunchConfiguration("use_sim_time").perform(context) == "true"}
    parameters = [*parameter_file(context, share, name), sim_time]
    nodes = [
        Node(
            package="course_exercises",
            executable=program,
            name=node or None,
            parameters=parameters,
            output="screen",
        )
        for program, node in EXERCISES[name]
    ]
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(share / "rviz" / "course.rviz")],
        parameters=[sim_time],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    return [mock_robot(context, name), *nodes, rviz]


def mock_robot(context: LaunchContext, name: str) -> IncludeLaunchDescription:
    """Return the robot in the scenario that was asked for, or in the exercise's."""
    launch = Path(get_package_share_directory("course_sim")) / "launch" / "sim.launch.py"
    asked = LaunchConfiguration("scenario").perform(context)
    scenario = asked or SCENARIOS.get(name, SCENARIO)
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(launch)),
        launch_arguments={
            "scenario": scenario,
            "clock": LaunchConfiguration("use_sim_time").perform(context),
        }.items(),
        condition=IfCondition(LaunchConfiguration("mock")),
    )


def parameter_file(context: LaunchContext, share: Path, name: str) -> list[str]:
    """Return the file that was asked for, or the exercise's; none if it has no parameters.

    Raises
    ------
    FileNotFoundError
        The file that was asked for is not there.
    """
    asked = LaunchConfiguration("params").perform(context)
    file = Path(asked) if asked else share / "config" / f"{name}.yaml"
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
