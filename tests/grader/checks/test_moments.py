"""Failures that are about a whole run open its replay at the most telling moment."""

import ast
from pathlib import Path

import numpy as np
import pytest
from node_runs import PREAMBLE, RunNode, short

from grader.checks.moments import came_to_rest, first_asked, first_contact
from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import Submission
from grader.exercises.obstacle_avoidance.contract import right_speeds
from grader.grading.grading import Grading, grade_submission
from grader.grading.plugin import CheckResult
from grader.link.hosts import ForkServer

# A wrong end of a topic is wrong all the time; a training has no robot; and who answered too few
# scans has a check that says why.
GRADER = ROOT / "grader"
WITHOUT = {
    ("wiring.py", "_require_end"),
    ("wiring.py", "_fail_missing"),
    ("wiring.py", "_fail_type"),
    ("callbacks.py", "quick"),
    ("words.py", "logs"),
}
TRAINING = "ml_velocity/test_training.py"
ALWAYS = """
class Same(Echo):
    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = {speed}
        self.publisher.publish(twist)
rclpy.init()
rclpy.spin(Same('obstacle_avoidance_agent'))
"""


def graded(forkserver: ForkServer, tmp_path: Path, source: str, *only: str) -> Grading:
    file = tmp_path / "obstacle_avoidance_agent.py"
    file.write_text(PREAMBLE + source)
    exercise = find_exercise("obstacle_avoidance")
    return grade_submission(exercise, Submission(file), forkserver, file=file.name, only=only)


def failure(grading: Grading, name: str) -> CheckResult:
    (check,) = (check for check in grading.checks if check.id == name)
    assert check.outcome == "fail"
    return check


def test_a_node_that_always_stands_is_shown_where_it_should_drive(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    grading = graded(forkserver, tmp_path, ALWAYS.format(speed=0.0), "stop_zone")

    check = failure(grading, "stop_zone")
    assert check.message == "the node says the same whatever it sees"
    (recording,) = (run for run in grading.recordings if run.name == check.scenario)
    assert check.time == next(s.t for s in recording.scans() if 0.0 not in right_speeds(s))


def test_where_a_robot_comes_to_rest(run_node: RunNode) -> None:
    drives = """
        class Drives(Echo):
            def on_scan(self, scan):
                self.seen = getattr(self, 'seen', 0) + 1
                twist = Twist()
                twist.linear.x = 0.3 if self.seen < 10 else 0.0
                self.publisher.publish(twist)
        rclpy.init(); rclpy.spin(Drives())
    """
    recording = run_node(drives, short(3.0))
    rest = came_to_rest(recording)
    assert rest is not None
    assert 0.9 < rest < 2.0
    assert np.ptp(recording.truth.x[recording.truth.t / 1e9 >= rest]) < 1e-3
    assert first_contact(recording) is None


def test_where_a_robot_never_moves(run_node: RunNode) -> None:
    recording = run_node("rclpy.init(); rclpy.spin(Echo())", short(1.0))

    assert came_to_rest(recording) == first_asked(recording) == recording.scans()[0].t


def test_without_a_message_there_is_no_moment(run_node: RunNode) -> None:
    recording = run_node("rclpy.init(); rclpy.spin(Echo())", short(0.003))

    assert recording.delivered == ()
    assert first_asked(recording) is None
    assert came_to_rest(recording) is None


@pytest.mark.parametrize(
    "file",
    sorted(file for room in ("checks", "exercises") for file in (GRADER / room).rglob("*.py")),
    ids=lambda file: file.relative_to(GRADER).as_posix(),
)
def test_what_tells_a_student_what_was_expected_tells_when(file: Path) -> None:
    """What has no `expected` is no mistake of a student: a scenario that ended too early."""
    name = file.relative_to(GRADER).as_posix().partition("/")[2]
    for function in ast.walk(ast.parse(file.read_text("utf-8"))):
        if not isinstance(function, ast.FunctionDef) or (name, function.name) in WITHOUT:
            continue
        for call in ast.walk(function):
            if not isinstance(call, ast.Call) or ast.unparse(call.func) != "fail":
                continue
            given = {keyword.arg for keyword in call.keywords}
            if "expected" in given and name != TRAINING:
                assert {"at", "recording"} <= given, f"{name}:{call.lineno} fails without a moment"
