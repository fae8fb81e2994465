"""What a node answers to those who set its parameters: it is asked, and its answers are hostile."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.parameters import ANSWERS, SETTER, orders
from grader.course.submission import find_submission
from grader.drive import drive_node
from grader.drive.topics import topic_lines
from rclpy_virtual_time.link.hosts import ForkServer
from sim.messages import STRING, string
from sim.scenario_files import load_scenario

NODE = """
import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
rclpy.init()
node = rclpy.create_node("adjustable")
span = FloatingPointRange(from_value=0.0, to_value=0.5)
node.declare_parameter("speed", 0.3, ParameterDescriptor(floating_point_range=[span]))
rclpy.spin(node)
"""


def test_a_node_is_asked_while_it_runs(tmp_path: Path, forkserver: ForkServer) -> None:
    (tmp_path / "node.py").write_text(NODE)
    submission = find_submission(tmp_path / "node.py")
    for_the_node = ["--ros-args", "-p", "spare:=1"]  # not for the program beside it
    scenario = load_scenario("live_knob")
    recording = drive_node(submission, scenario, forkserver, arguments=for_the_node)
    first, second = orders(recording)
    assert (first.at, first.wanted, second.wanted) == (3.0, {"speed": 0.1}, {"speed": 30.0})
    assert first.answer and first.answer.accepted
    assert second.answer and not second.answer.accepted
    assert "out of range" in second.answer.reason
    assert "parameters" not in "".join(topic_lines(recording))  # the grader's ends are not told


@pytest.mark.parametrize(
    "said",
    [
        "yes",
        "[1]",
        "[" * 100_000,
        "\ud800",
        '{"order": 0, "accepted": 1}',
        '{"order": 0, "described": [{"name": "a", "type": 3, "limits": [1' + "0" * 400 + "]}]}",
    ],
)
def test_what_is_no_answer_is_none(said: str) -> None:
    program = SimpleNamespace(file=SETTER, arguments=("adjustable", "1.5 speed:=0.1 word:=a"))
    text = said.encode(errors="replace").decode()
    recording: Any = SimpleNamespace(
        published=[string(ANSWERS, 0, text)],
        live=None,
        scenario=SimpleNamespace(program=(program,)),
    )
    (order,) = orders(recording)
    assert (order.at, order.wanted, order.answer) == (1.5, {"speed": 0.1, "word": "a"}, None)
    assert recording.published[0].type == STRING
