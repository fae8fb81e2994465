"""Driving any node: the scenario with changes, and the summary."""

from dataclasses import replace

import pytest
from node_runs import RunNode, short

from grader.drive import arguments_of, print_summary, scenario_for
from grader.errors import InputError
from grader.recording import Outcome, Recording
from sim.scenario import load_scenario


def test_without_changes_it_is_the_scenario() -> None:
    assert scenario_for("demo_wall") == load_scenario("demo_wall")


@pytest.mark.parametrize("profile", ["default", "lds01", "lds02", "wide"])
def test_another_lidar(profile: str) -> None:
    assert scenario_for("demo_wall", lidar=profile).lidar.profile == profile


def test_another_duration() -> None:
    assert scenario_for("demo_wall", duration=3.5).duration == 3.5


def test_goals_are_spread_over_the_drive() -> None:
    script = scenario_for("demo_wall", duration=9.0, goals=[(1, 2), (3, 4), (5, 6)]).script

    assert [(event.at, event.goal) for event in script] == [
        (0.5, (1, 2, 0.0)),
        (3.5, (3, 4, 0.0)),
        (6.5, (5, 6, 0.0)),
    ]


def test_goals_replace_those_of_the_scenario_only() -> None:
    before = load_scenario("goal_arrival").script
    after = scenario_for("goal_arrival", goals=[(1, 2)]).script

    assert [event for event in after if event.goal is None] == [
        event for event in before if event.goal is None
    ]
    assert [event.goal for event in after if event.goal is not None] == [(1, 2, 0.0)]


@pytest.mark.parametrize("profile", ["lds1", "", "LDS01", "../default"])
def test_unknown_lidars(profile: str) -> None:
    with pytest.raises(InputError, match="unknown lidar profile"):
        scenario_for("demo_wall", lidar=profile)


@pytest.mark.parametrize("duration", [float("nan"), float("inf"), 0.0, -1.0])
def test_durations_that_are_none(duration: float) -> None:
    with pytest.raises(InputError, match="--duration"):
        scenario_for("demo_wall", duration=duration)


def test_parameters_become_arguments() -> None:
    assert arguments_of([]) == []
    assert arguments_of(["speed:=0.3", "a.b_c:=two words"]) == [
        "--ros-args", "-p", "speed:=0.3", "-p", "a.b_c:=two words",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "param", ["", "x", "x=1", ":=1", "x:=", "-x:=1", "a b:=1", "1x:=1", "x: =1"]
)
def test_malformed_parameters(param: str) -> None:
    with pytest.raises(InputError, match="expected NAME:=VALUE"):
        arguments_of([param])


@pytest.fixture
def drive(run_node: RunNode) -> Recording:
    return run_node("rclpy.init(); rclpy.spin(Echo())", short(1.0))


def summary(recording: Recording, capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    print_summary(recording, file="echo.py")
    return " ".join(capsys.readouterr().out.split())


def test_the_summary(drive: Recording, capsys: pytest.CaptureFixture[str]) -> None:
    said = summary(drive, capsys)

    assert said.startswith("echo.py in demo_wall, seed 1 Topics")
    assert "-> /cmd_vel geometry_msgs/msg/Twist reliable 10 messages (10.0 Hz)" in said
    assert "<- /scan sensor_msgs/msg/LaserScan reliable 10 messages (10.0 Hz)" in said
    assert "1.0 s simulated; the node ran to the end" in said
    assert "drove 0.00 m" in said


def test_what_is_wrong_with_the_topics(
    run_node: RunNode, capsys: pytest.CaptureFixture[str]
) -> None:
    said = summary(
        run_node(
            """
            rclpy.init(); node = Node('wrong')
            node.create_subscription(String, '/scan', print, 10)
            node.create_subscription(LaserScan, '/laser', print, 10)
            node.create_publisher(Twist, '/cmd_vel', 10)
            rclpy.spin(node)
            """,
            short(0.5),
        ),
        capsys,
    )

    assert "WARNING: nothing arrives: the robot publishes sensor_msgs/msg/LaserScan" in said
    assert "WARNING: the robot sends nothing on this topic" in said
    assert "the robot got no command" in said


def test_texts_of_students_are_not_markup(
    drive: Recording, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = Outcome("exception", "[bold]E[/] \x1b[31m", 0.5, "[/] \x1b]0;title\x07 detail")
    said = summary(replace(drive, outcome=outcome), capsys)

    assert "[bold]E[/]" in said
    assert "\x1b" not in said
    assert "\x07" not in said


def test_a_node_that_never_started(drive: Recording, capsys: pytest.CaptureFixture[str]) -> None:
    nothing = replace(drive, endpoints=(), delivered=(), published=(), duration_s=0.0)
    said = summary(nothing, capsys)

    assert "the node created no publisher and no subscription" in said
