"""The rows above the prompt, of real gradings of nodes with one mistake each."""

import io
from pathlib import Path

import pytest

from grader.course.exercises import SOLUTIONS, find_exercise
from grader.course.submission import Submission
from grader.grading.grading import grade_submission
from grader.report.facts import seen_of
from grader.report.terminal import ROWS, Console, render_terminal
from rclpy_virtual_time.link.hosts import ForkServer

EXERCISE = find_exercise("obstacle_avoidance")
REFERENCE = (SOLUTIONS / EXERCISE.slug / EXERCISE.files[0]).read_text("utf-8")
NONE_OR, STOP = "distance is None or ", "    def stop(self)"
SPEED = "twist.linear.x = speed"
PUBLISHER = 'create_publisher(Twist, "/cmd_vel", 10)'
MISTAKES = {  # what stands there, what stands instead: what the cause says
    "a fence": ('"""Obstacle avoidance:', '```python\n"""Obstacle:', "``` is Markdown"),
    "a magic": ('"""Obstacle avoidance:', '%%node a.py\n"""Obstacle:', "no line of a notebook"),
    "a colon": ("def stop(self) -> None:", "def stop(self)", "ends with a colon"),
    "ROS 1": ("import rclpy\n", "import rospy\n", "belongs to ROS 1"),
    "queue_size": (PUBLISHER, PUBLISHER.replace("10", "queue_size=10"), "depth is the last"),
    "the order": (PUBLISHER, 'create_publisher("/cmd_vel", Twist, 10)', "the message type, the t"),
    "a class": ("twist = Twist()", "twist = Twist", "brackets make one"),
    "an owned name": ("self.scan_subscription =", "self.subscriptions =", "self.my_subscriptions"),
    "nothing": (NONE_OR, "", "Here distance is None: ask"),
    "an or": (NONE_OR, "distance is not None and distance > 9.0 or ", "brackets say what"),
    "a rate": (SPEED, f"{SPEED}\n        self.create_rate(10).sleep()", "needs no sleep"),
    "asyncio": (SPEED, f"{SPEED}; import asyncio; asyncio.get_running_loop()", "a thread do"),
    "a field": (SPEED, "twist.linear.X = speed", "it has x, y, z"),
    "defined twice": (STOP, f"    def drive(self, speed): pass\n\n{STOP}", "defines drive in line"),
    "a library": ("import rclpy\n", "import cv2\nimport rclpy\n", "There is no cv2 here"),
}


@pytest.mark.parametrize(("there", "instead", "said"), MISTAKES.values(), ids=MISTAKES)
def test_a_student_sees_the_cause_beside_the_prompt(
    forkserver: ForkServer, tmp_path: Path, there: str, instead: str, said: str
) -> None:
    file = tmp_path / EXERCISE.files[0]
    assert there in REFERENCE
    file.write_text(REFERENCE.replace(there, instead), "utf-8")
    only = ("wiring", "slow_zone", "blind")
    grading = grade_submission(EXERCISE, Submission(file), forkserver, file=file.name, only=only)

    screen = io.StringIO()
    render_terminal(grading.as_dict(), Console(file=screen, width=80), todo="course why")
    rows = screen.getvalue().rstrip("\n").split("\n")
    (first,) = (i for i, row in enumerate(rows) if row.startswith(" Cause"))

    assert len(rows) - first <= ROWS
    assert said in " ".join(" ".join(rows[first:]).split())
    assert " Score" in "\n".join(rows[first:])
    assert rows[-1].startswith(" Next")


def test_a_long_wish_leaves_room_for_what_came() -> None:
    check = {"expected": "reason = " + " or ".join(f"“word {n}”" for n in range(20)), "time": 0.05}
    said = seen_of({**check, "actual": "reason = “Reason.OK”", "scenario": "safe_plain"})
    assert said.endswith(" …; actual reason = “Reason.OK”; at 0.05 s in safe_plain")
    assert len(said) < 140
