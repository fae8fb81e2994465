"""What is said about exceptions that come from where a node runs."""

import inspect
import re
import urllib.error
from pathlib import Path

import pytest
from node_runs import RunNode, short

from grader.advice import hints
from grader.advice.hints import (
    CONTEXT,
    FILES,
    KEYBOARD,
    MEMORY,
    NETWORK,
    PROCESSES,
    SPACE,
    hint,
    missing_package,
)
from grader.cli import cli
from grader.course.submission import find_submission
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer

REFUSED = {
    "subprocess": ("import subprocess; subprocess.run(['echo', 'hi'])", PROCESSES),
    "os.fork": ("os.fork()", PROCESSES),
    "a socket": ("import socket; socket.socket()", NETWORK),
    "a download": ("import urllib.request; urllib.request.urlopen('http://example.com')", NETWORK),
    "a file elsewhere": ("open('/tmp/x', 'w')", FILES),
    "too much memory": ("bytearray(5 << 30)", MEMORY),
    "too much memory of numpy's": ("import numpy; numpy.zeros((5 << 30,), 'u1')", MEMORY),
    "a full folder": ("for n in range(6): open(f'f{n}', 'wb').write(bytes(60 << 20))", SPACE),
    "input": ("input('speed? ')", KEYBOARD),
    "a terminal": ("import termios; termios.tcgetattr(sys.stdin)", KEYBOARD),
    "rolling's init": ("with rclpy.init(): pass", CONTEXT),
    "an environment variable": (
        "os.environ['TURTLEBOT3_MODEL']",
        "environment variables are not passed on to a node: `course drive --env TURTLEBOT3_MODEL"
        "=VALUE` sets this one; what is handed in takes a ROS parameter instead",
    ),
    "an exception from another": (
        """
        try:
            os.fork()
        except OSError:
            raise RuntimeError('no child')
        """,
        PROCESSES,
    ),
}


@pytest.mark.parametrize(("source", "advice"), REFUSED.values(), ids=REFUSED)
def test_what_the_sandbox_refuses(run_node: RunNode, source: str, advice: str) -> None:
    outcome = run_node(source).outcome

    assert outcome.kind == "exception"
    assert outcome.text.endswith(f"; {advice}")
    assert re.search(r"\(line \d+, in <module>\)", outcome.text)


def test_a_shell_command_says_that_it_did_nothing(run_node: RunNode) -> None:
    recording = run_node("print(os.system('clear')); rclpy.init(); rclpy.spin(Echo())")
    said = [(line.level, line.text) for line in recording.log]

    assert recording.outcome.completed
    assert ("stdout", "32512") in said
    assert ("stderr", f"os.system('clear') returned 32512: {PROCESSES}") in said


OWN = {
    "a value": "int('x')",
    "an import of one's own": "import no_such_module",
    "a refusal of one's own": "raise PermissionError('not you')",
    "an exception that can't be shown": """
        class Odd(OSError):
            errno = property(lambda self: 1 / 0)
        raise Odd
    """,
}


@pytest.mark.parametrize("source", OWN.values(), ids=OWN)
def test_exceptions_of_the_program_itself_get_no_advice(run_node: RunNode, source: str) -> None:
    outcome = run_node(source).outcome

    assert outcome.kind == "exception"
    assert outcome.text.endswith("in <module>)")


def test_a_module_of_ones_own_package_has_its_name(run_node: RunNode) -> None:
    outcome = run_node("""
        import os
        os.mkdir('my_robot')
        for name, line in (('perception', ''), ('driver', 'import perception'), ('__init__', '')):
            open(f'my_robot/{name}.py', 'w').write(line)
        import my_robot.driver
    """).outcome

    assert "`from my_robot.perception import …`" in outcome.text


@pytest.mark.parametrize("name", ["logging.py", "rclpy.py", "rclpy/__init__.py"])
def test_a_file_beside_the_node_that_hides_a_module(
    name: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("LEVEL = 1\n")
    (tmp_path / "node.py").write_text("from rclpy.node import Node\n")
    outcome = run_trial(find_submission(tmp_path / "node.py"), short(0.1), forkserver).outcome

    module = name.split(".", maxsplit=1)[0].split("/", maxsplit=1)[0]
    what = "the folder rclpy/" if "/" in name else name
    assert f"`import {module}` finds {what} beside the node" in outcome.text


def test_a_package_of_ros_that_is_not_installed(run_node: RunNode) -> None:
    outcome = run_node("from no_such_robot_msgs.msg import State").outcome

    assert "No module named 'no_such_robot_msgs'" in outcome.text
    assert "lay the folder no_such_robot_msgs, with its msg/, srv/ or action/" in outcome.text


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("tf2_ros", "`sudo apt install ros-jazzy-tf2-ros-py`"),
        ("tf2_msgs", "`sudo apt install ros-jazzy-tf2-msgs`"),
        ("tf", "in ROS 2 it is tf2_ros"),
        ("rospy", "in ROS 2 it is rclpy"),
        (
            "pizza_interfaces",
            "beside the node; of a package, beside that, and hand in the folder above both",
        ),
        ("turtlesim", "from github.com/ros/ros_tutorials"),
        ("neato2_interfaces", "from github.com/comprobo23/neato_packages"),
    ],
)
def test_where_a_package_comes_from(name: str, advice: str) -> None:
    assert advice in missing_package(name)


@pytest.mark.parametrize("name", ["", "torch", "msgs", "interfaces", "my_helper", "cv2"])
def test_packages_that_are_not_of_ros(name: str) -> None:
    assert missing_package(name) == ""


def test_causes_that_go_in_a_circle() -> None:
    first, second = OSError(1, "a"), OSError(1, "b")
    first.__cause__, second.__cause__ = second, first
    assert hint(first) == ""
    assert hint(urllib.error.URLError(first)) == ""


def test_os_system_is_still_found_by_pickle(run_node: RunNode) -> None:
    recording = run_node("""
        import pickle
        print(pickle.loads(pickle.dumps(os.system)) is os.system)
    """)
    assert [line.text for line in recording.log if line.level == "stdout"] == ["True"]


def test_the_options_that_hints_name_are_there() -> None:
    named = re.findall(r"course drive (--?\w+)", inspect.getsource(hints))
    there = {option for each in cli.commands["drive"].params for option in each.opts}

    assert len(named) > 1
    assert set(named) <= there
