"""What exercises 2 and 8 ask of a node with a model.

How long a scan may wait for its command in real time: test_real_time_yields.py.
"""

from types import SimpleNamespace
from typing import Any

import pytest
from node_runs import RunNode, short

from grader.checks.commands import answers
from grader.checks.model_commands import (
    require_error_log,
    require_safe_drive,
    require_speed,
    scan_in_words,
)
from grader.checks.predictions import SpeedInterval
from grader.checks.verdict import CheckFailed
from grader.recording import Recording

QUARTER = SpeedInterval(0.25, 0.25)
NODE = """
class Agent(Echo):
    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = {speed}
        {log}
        self.publisher.publish(twist)
rclpy.init()
rclpy.spin(Agent())
"""


def node(speed: str, log: str = "pass") -> str:
    return NODE.format(speed=speed, log=log)


def judge(recording: Recording, right: SpeedInterval = QUARTER) -> None:
    answer = answers(recording)[0]
    require_speed(recording, answer, right, 1e-3, what=scan_in_words(recording, answer), help="")


def test_the_right_speed_passes(run_node: RunNode) -> None:
    judge(run_node(node("0.2505"), short(0.5)))


@pytest.mark.parametrize(
    ("speed", "actual"),
    [("0.252", "0.2520"), ("float('nan')", "nan"), ("100.0", "100.00")],
)
def test_another_speed_fails(run_node: RunNode, speed: str, actual: str) -> None:
    with pytest.raises(CheckFailed, match=r"^the scan at \d\.\d{3} s: wrong speed$") as caught:
        judge(run_node(node(speed), short(0.5)))
    assert caught.value.expected == "linear.x = 0.25 m/s"
    assert caught.value.actual == f"linear.x = {actual} m/s"


def test_no_command_fails(run_node: RunNode) -> None:
    silent = run_node("rclpy.init(); rclpy.spin(Node('silent'))", short(0.5))
    with pytest.raises(CheckFailed, match="there was still no command after the scan at"):
        judge(silent)


@pytest.mark.parametrize(("loss", "words"), [(0.0, "“a wall”"), (0.2, "the scan at 1.500 s")])
def test_a_label_names_a_scan_unless_scans_are_lost(loss: float, words: str) -> None:
    answer: Any = SimpleNamespace(label="a wall", scan=SimpleNamespace(t=1.5))
    faults = SimpleNamespace(scan_loss=loss)
    recording: Any = SimpleNamespace(scenario=SimpleNamespace(faults=faults))
    assert scan_in_words(recording, answer) == words


def test_an_error_has_to_be_in_the_log(run_node: RunNode) -> None:
    require_error_log(run_node(node("0.0", "self.get_logger().error('gone')"), short(0.5)), "")
    warned = run_node(node("0.0", "self.get_logger().warning('gone')"), short(0.5))
    with pytest.raises(CheckFailed, match="no word of it") as caught:
        require_error_log(warned, "no word of it")
    assert caught.value.actual == "lines of level warn only"


@pytest.mark.parametrize(
    ("speed", "seconds", "message"),
    [
        ("0.5", 10.0, "with your model the robot ran into something"),
        ("0.0", 1.0, "with your model the robot hardly moves"),
        ("0.2", 5.0, "with your model the robot hardly moves"),  # far enough, but never fast
    ],
)
def test_an_unsafe_or_idle_drive_fails(
    run_node: RunNode, speed: str, seconds: float, message: str
) -> None:
    recording = run_node(node(speed), short(seconds))
    with pytest.raises(CheckFailed, match=message):
        require_safe_drive(recording, "your")


def test_a_brisk_drive_without_contact_is_safe(run_node: RunNode) -> None:
    require_safe_drive(run_node(node("0.5"), short(2.5)), "your")
