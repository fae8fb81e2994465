"""The course's own code in a submission: a pasted oracle is told, a right solution is not."""

import pytest

from grader.classroom.results.similarity import compared
from grader.course.exercises import ROOT, Exercise, all_exercises

NODE = b"""
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from geometry_msgs.msg import Twist

rclpy.init()
node = Node("agent")
publisher = node.create_publisher(Twist, "/cmd_vel", 10)

def answer(scan):
    twist = Twist()
    twist.linear.x = min(right_speeds(scan))
    publisher.publish(twist)

node.create_subscription(LaserScan, "/scan", answer, 10)
rclpy.spin(node)
"""


def given(exercise: Exercise) -> dict[str, bytes]:
    return {file: (exercise.folder / file).read_bytes() for file in exercise.files}


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_right_solutions_hold_no_checks(exercise: Exercise) -> None:
    texts = {
        path.stem: {exercise.files[0]: path.read_bytes()}
        for path in (exercise.solutions / "variants").glob("*.py")
    }
    if exercise.files[0].endswith("launch.py"):
        texts = {}  # they are all alike, and short
    taken = compared(texts, {}, exercise.slug).taken
    assert len(taken) >= len(texts)  # each is like itself, or like one that is closer
    assert {pair.right.partition("/")[0] for pair in taken} == ({"solutions"} if texts else set())


@pytest.mark.parametrize("number", [1, 4, 7])
def test_a_pasted_oracle_is_told_of(number: int) -> None:
    exercise = all_exercises()[number - 1]
    oracle = exercise.judge / "contract.py"
    pasted = oracle.read_bytes().replace(b"scan", b"reading") + NODE
    texts = {who: {exercise.files[0]: pasted} for who in ("ada", "ben")} | {"chen": given(exercise)}

    found = compared(texts, {}, exercise.slug)
    assert [pair.left for pair in found.taken] == ["ada", "ben"]
    assert {pair.right for pair in found.taken} == {oracle.relative_to(ROOT).as_posix()}
    assert found.taken[0].similarity > 0.5
    assert found.groups == ()  # what they have in common is the course's


def test_a_copied_reference_is_told_of() -> None:
    exercise = all_exercises()[2]
    reference = (exercise.solutions / exercise.files[0]).read_bytes().replace(b"self.", b"this.")
    (pair,) = compared({"ada": {exercise.files[0]: reference}}, {}, exercise.slug).taken
    assert pair.right == f"solutions/{exercise.slug}/{exercise.files[0]}"
