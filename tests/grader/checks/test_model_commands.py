"""What is asked of a node with a model."""

import pytest
from node_runs import RunNode, short

from grader.checks.commands import answers
from grader.checks.model_cases import scan_in_words
from grader.checks.model_commands import require_error_log, require_speed
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
    [("0.252", "0.252"), ("float('nan')", "nan"), ("100.0", "100.00")],
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


def test_an_error_has_to_be_in_the_log(run_node: RunNode) -> None:
    require_error_log(run_node(node("0.0", "self.get_logger().error('gone')"), short(0.5)), "")
    warned = run_node(node("0.0", "self.get_logger().warning('gone')"), short(0.5))
    with pytest.raises(CheckFailed, match="no word of it") as caught:
        require_error_log(warned, "no word of it")
    assert caught.value.actual == "lines of level warn only"
