"""The course's own code in a submission: a pasted oracle is told, a right solution is not."""

import pytest

from grader.classroom.results.similarity import own_code, words_of
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
    found = own_code(words_of(texts), given(exercise), exercise.slug)
    assert [match for match in found if match.source.startswith("grader/")] == []


@pytest.mark.parametrize("number", [1, 4, 7])
def test_a_pasted_oracle_is_told_of(number: int) -> None:
    exercise = all_exercises()[number - 1]
    oracle = exercise.judge / "contract.py"
    pasted = oracle.read_bytes().replace(b"scan", b"reading") + NODE
    texts = {"ada": {exercise.files[0]: pasted}, "ben": given(exercise)}

    (match,) = own_code(words_of(texts), given(exercise), exercise.slug)
    assert match.student == "ada"
    assert match.source == oracle.relative_to(ROOT).as_posix()
    assert match.similarity > 0.5


def test_a_copied_reference_is_told_of() -> None:
    exercise = all_exercises()[2]
    reference = (exercise.solutions / exercise.files[0]).read_bytes().replace(b"self.", b"this.")
    found = own_code(
        words_of({"ada": {exercise.files[0]: reference}}), given(exercise), exercise.slug
    )
    assert [match.source for match in found] == [f"solutions/{exercise.slug}/{exercise.files[0]}"]
