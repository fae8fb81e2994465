"""Each way in which a node may not be wired has its own diagnosis."""

from pathlib import Path

import pytest
from node_runs import RunNode, short

from grader.checks.verdict import CheckFailed
from grader.checks.wiring import require_alive, require_wiring
from grader.course.submission import find_submission
from grader.trial.virtual_time import run_trial

NODE = """
class Agent(Node):
    def __init__(self):
        super().__init__('agent')
        {publisher}
        {subscription}
    def on_scan(self, scan):
        {callback}
rclpy.init()
rclpy.spin(Agent())
"""
PUBLISHER = "self.create_publisher(Twist, '/cmd_vel', 10)"
SUBSCRIPTION = "self.create_subscription(LaserScan, '/scan', self.on_scan, 10)"
TRANSIENT = (
    "from rclpy.qos import DurabilityPolicy, QoSProfile; "
    "self.create_subscription(LaserScan, '/scan', self.on_scan, "
    "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))"
)


def node(
    publisher: str = PUBLISHER, subscription: str = SUBSCRIPTION, callback: str = "pass"
) -> str:
    return NODE.format(publisher=publisher, subscription=subscription, callback=callback)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (node(SUBSCRIPTION, "pass"), "there is no publisher on /cmd_vel$"),
        (
            node(PUBLISHER.replace("/cmd_vel", "/cmd_vell")),
            "there is no publisher on /cmd_vel, but one on /cmd_vell",
        ),
        (
            node(PUBLISHER, "self.create_publisher(LaserScan, '/scan', 10)"),
            "there is a publisher on /scan where a subscription is needed",
        ),
        (
            node(PUBLISHER.replace("Twist", "TwistStamped")),
            "the publisher on /cmd_vel has the type TwistStamped; the robot's end of it is Twist",
        ),
        (node(PUBLISHER, TRANSIENT), "cannot talk: their QoS does not match"),
        (
            node(callback="raise KeyError('x')"),
            "the node died of an exception in the callback of /scan, after the message",
        ),
        ("raise KeyError('x')", "the node died of an exception in the start-up"),
        ("rclpy.init()", "the program ran to its end"),
    ],
)
def test_what_is_wrong_is_said(run_node: RunNode, source: str, message: str) -> None:
    recording = run_node(source, short(0.5))
    with pytest.raises(CheckFailed, match=message) as caught:
        require_wiring(recording, "obstacle_avoidance")
    assert caught.value.expected
    assert caught.value.help


def test_the_line_of_the_student_is_named(run_node: RunNode) -> None:
    recording = run_node(node(callback="raise KeyError('x')"), short(0.5))
    with pytest.raises(CheckFailed) as caught:
        require_alive(recording)
    assert "in on_scan" in caught.value.where
    assert "raise KeyError('x')" in caught.value.where
    assert caught.value.at == recording.scans()[0].t


def test_a_program_that_never_makes_a_node_is_asked_for_its_main(run_node: RunNode) -> None:
    with pytest.raises(CheckFailed) as failed:
        require_alive(run_node("def main():\n    rclpy.init()\n", short(0.5)))
    assert "It never made a node" in str(failed.value.help)


@pytest.mark.parametrize(("source", "help"), [("", ""), ("# \udce4\n", "look at the line")])
def test_a_line_is_looked_at_only_where_one_is_named(
    tmp_path: Path, source: str, help: str
) -> None:
    file = tmp_path / "agent.py"
    file.write_bytes(source.encode("utf-8", "surrogateescape"))
    with pytest.raises(CheckFailed) as failed:
        require_alive(run_trial(find_submission(file), short(0.5), None))  # type: ignore[arg-type]
    assert help in failed.value.help
    assert bool(failed.value.help) == bool(help)
