"""What a scenario or a person asks of parameters reaches the node, or the trial says so."""

from pathlib import Path

import pytest
from laid_packages import MINE, lay
from node_runs import RunNode, short

from grader.course.submission import find_submission
from grader.recording import noted_of
from grader.trial.packages import unpacked
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer

ASKED = ("--ros-args", "-p", "word:=mine")
NUMBER = ("--ros-args", "-p", "number:=.nan")
WILD = "/**:\n  ros__parameters: {word: 3}\n"  # of another type: rclpy takes integers first
EXACT = "/a/node:\n  ros__parameters: {word: exact}\n/*/node:\n  ros__parameters: {word: star}\n"
BEFORE = (  # what a launch file may say of a parameter
    "parameters=['config/p.yaml']",
    "parameters=[{'word': 2}, 'config/p.yaml']",
    "name='node', parameters=[{'word': 'dict'}, 'config/p.yaml']",
    "parameters=['config/p.yaml', {'word': 2.5}]",
    "arguments=['--ros-args', '-p', 'word:=7', '-p', 'node:word:=8']",
    "ros_arguments=['--params-file', 'config/p.yaml', '-p', 'word:=true']",
)
LAUNCH = """
from launch import LaunchDescription
from launch_ros.actions import Node, SetParameter
def generate_launch_description():
    return LaunchDescription([SetParameter(name='word', value=5), {nodes}])
"""


def test_what_is_asked_for_wins(runtime: ForkServer, tmp_path: Path) -> None:
    nodes = [f"Node(package='mine', executable='one', namespace='a', {how})" for how in BEFORE]
    launch, config = LAUNCH.format(nodes=", ".join(nodes)), WILD + EXACT
    files = {"launch/all.launch.py": launch, "config/p.yaml": config}
    submission = unpacked(find_submission(lay(tmp_path, {**MINE, **files})), runtime)
    recording = run_trial(submission, short(0.2), runtime, arguments=ASKED)
    assert recording.outcome.completed, recording.outcome
    assert [line.text.split()[-2] for line in recording.log] == ["mine"] * len(BEFORE)
    assert not noted_of(recording)


NONE = "no node declares word, so that has no effect; declared here: "
DECLARES = "node.declare_parameter('word', 'own')"
NODES = {
    "rclpy.init()\nnode = Node('n')": f"{NONE}nothing",
    "rclpy.init()\nnode = Node('n')\nnode.declare_parameter('wort', '')": f"{NONE}wort",
    "rclpy.init()\nnode = Node('n', allow_undeclared_parameters=True)": "",
    "rclpy.init()\nnode = Node('n', automatically_declare_parameters_from_overrides=True)": "",
    f"rclpy.init(args=[])\nnode = Node('n')\n{DECLARES}": "/n did not get what was asked for: word "
    "('own', not mine); ",
    f"rclpy.init()\nnode = Node('n')\n{DECLARES}": "",
    "rclpy.init()\nnode = Node('n')\nnode.declare_parameter('number', 0.5)": "",
}


@pytest.mark.parametrize("source", NODES)
def test_what_does_not_arrive_is_said(source: str, run_node: RunNode) -> None:
    arguments = NUMBER if "number" in source else ASKED
    recording = run_node(f"{source}\nrclpy.spin(node)", short(0.2), arguments=arguments)
    assert recording.outcome.completed, recording.outcome
    said = noted_of(recording)
    assert len(said) == bool(NODES[source])
    assert "".join(said).startswith(NODES[source])
