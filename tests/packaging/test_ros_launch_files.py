"""The launch files: what they take, and which nodes they start with what."""

from pathlib import Path

import pytest
import yaml
from ros_launch import Node, arguments, started

from grader.course.exercises import ROOT, all_exercises
from sim.live import cli
from sim.live.options import Options
from sim.messages import GOAL_TOPIC, ODOM_FRAME, ODOM_TOPIC, SCAN_TOPIC
from sim.scenario_files import load_scenario

SIM = ROOT / "sim" / "launch" / "sim.launch.py"
EXERCISE = ROOT / "exercises" / "launch" / "exercise.launch.py"
SLUGS = [exercise.slug for exercise in all_exercises()]


@pytest.fixture(autouse=True)
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An ament index with our two packages, as colcon's install space has it."""
    index = tmp_path / "share" / "ament_index" / "resource_index" / "packages"
    index.mkdir(parents=True)
    for name, folder in (("course_sim", "sim"), ("course_exercises", "exercises")):
        (index / name).touch()
        (tmp_path / "share" / name).symlink_to(ROOT / folder)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    return tmp_path / "share"


def names(nodes: list[Node]) -> list[tuple[str | None, str]]:
    return [(node.package, node.executable) for node in nodes]


def test_the_robot_starts_in_a_hall_with_a_wall() -> None:
    (robot,) = started(SIM)
    assert (robot.package, robot.executable) == ("course_sim", "mock_robot")
    assert robot.arguments == ["--scenario", "demo_wall"]
    assert robot.output == "screen"
    assert robot.on_exit is not None, "what waits for a robot that has ended waits for ever"
    assert cli._options([]) == Options(), "what the launch file leaves empty is the robot's"


def test_every_argument_reaches_the_robot_which_takes_it() -> None:
    values = {"scenario": "avoid_cart", "lidar": "lds01", "rate": "2.0", "seed": "3",
              "record": "bag", "foxglove": "9000"}  # fmt: skip
    for end in ({"duration": "10"}, {"once": "true"}):
        (robot,) = started(SIM, **values, **end, clock="true", wait="true")
        options = cli._options(robot.arguments)
        assert (options.scenario, options.lidar) == ("avoid_cart", "lds01")
        assert (options.rate, options.seed, options.foxglove) == (2.0, 3, 9000)
        assert (options.record, options.clock, options.wait) == (Path("bag"), True, True)
        once = "once" in end
        assert (options.duration, options.once) == (None if once else 10.0, once)
    (robot,) = started(SIM, foxglove="true")
    assert robot.arguments[-1] == "--foxglove"


@pytest.mark.parametrize("argument", ["clock", "once", "wait"])
def test_a_switch_is_true_or_false(argument: str) -> None:
    with pytest.raises(RuntimeError, match="expected one of"):
        started(SIM, **{argument: "yes"})


@pytest.mark.parametrize("slug", SLUGS)
def test_an_exercise_starts_the_robot_and_its_nodes(slug: str) -> None:
    exercise = next(each for each in all_exercises() if each.slug == slug)
    robot, *nodes = started(EXERCISE, exercise=slug)
    assert names([robot]) == [("course_sim", "mock_robot")]
    programs = {Path(file).stem for file in exercise.files} - {"train_velocity_model"}
    here = {node.executable for node in nodes}
    by_itself = any(file.endswith("launch.py") for file in exercise.files)
    assert here <= programs if by_itself else here == programs  # its skeleton starts one
    assert all(node.package == "course_exercises" for node in nodes)
    scenario = load_scenario(robot.arguments[1])
    assert scenario.odometry.enabled, "RViz's fixed frame is odom"
    if any(topic.name == "/scan" for topic in exercise.topics):
        assert scenario.lidar.enabled
    if slug == "safety_supervisor":
        assert scenario.raw, "somebody has to ask it for something"


def test_the_launch_file_lists_the_exercises_that_there_are() -> None:
    assert sorted(SLUGS) == arguments(EXERCISE)["exercise"].choices
    with pytest.raises(RuntimeError, match="exercise is required"):
        started(EXERCISE)
    with pytest.raises(RuntimeError, match="expected one of"):
        started(EXERCISE, exercise="obstacles")


def test_three_clients_of_one_program_have_names_of_their_own() -> None:
    _, server, *clients = started(EXERCISE, exercise="model_server")
    assert server.executable == "detection_server"
    assert server.name is None, "the program's own"
    assert [client.name for client in clients] == [
        "navigation_client", "manipulation_client", "logging_client",
    ]  # fmt: skip
    (file, _) = clients[0].parameters
    assert isinstance(file, str)
    assert set(yaml.safe_load(Path(file).read_text("utf-8"))) == {
        "detection_server", *(client.name for client in clients),
    }  # fmt: skip


def test_parameters_are_the_exercises_or_ones_own(tmp_path: Path, packages: Path) -> None:
    _, node = started(EXERCISE, exercise="ml_velocity")
    assert node.parameters == [
        str(packages / "course_exercises" / "config" / "ml_velocity.yaml"),
        {"use_sim_time": False},
    ]
    own = tmp_path / "mine.yaml"
    own.touch()
    _, node = started(EXERCISE, exercise="ml_velocity", params=str(own))
    assert node.parameters[0] == str(own)
    _, node = started(EXERCISE, exercise="goal_seeking")
    assert node.parameters == [{"use_sim_time": False}], "this exercise has none"
    with pytest.raises(FileNotFoundError, match=r"params:=nowhere\.yaml: no such file"):
        started(EXERCISE, exercise="ml_velocity", params="nowhere.yaml")


def test_arguments_of_the_robot_pass_through_and_a_real_one_takes_its_place() -> None:
    robot, node = started(
        EXERCISE, exercise="obstacle_avoidance", use_sim_time="true", scenario="trend_wall"
    )
    assert robot.arguments == ["--scenario", "trend_wall", "--clock"], "simulated time needs one"
    assert node.parameters == [{"use_sim_time": True}]
    nodes = started(EXERCISE, exercise="obstacle_avoidance", mock="false")
    assert names(nodes) == [("course_exercises", "obstacle_avoidance_agent")]


def test_rviz_starts_when_it_is_asked_for(packages: Path) -> None:
    *_, rviz = started(EXERCISE, exercise="goal_seeking", rviz="true")
    assert (rviz.package, rviz.executable) == ("rviz2", "rviz2")
    assert rviz.arguments == ["-d", str(packages / "course_exercises" / "rviz" / "course.rviz")]
    shown = yaml.safe_load(Path(rviz.arguments[1]).read_text("utf-8"))["Visualization Manager"]
    topics = {each["Topic"]["Value"] for each in shown["Displays"] if "Topic" in each}
    assert topics == {SCAN_TOPIC, ODOM_TOPIC, GOAL_TOPIC}
    assert shown["Global Options"]["Fixed Frame"] == ODOM_FRAME
