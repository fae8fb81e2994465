"""Failures that are about a whole run open its replay at the most telling moment."""

import ast
from pathlib import Path

import numpy as np
import pytest
from node_runs import RunNode, short

from grader.checks.moments import came_to_rest, first_asked, first_contact
from grader.course.exercises import ROOT

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


def test_a_robot_that_never_moves_rests_at_its_first_scan(run_node: RunNode) -> None:
    spins = "rclpy.init(); rclpy.spin(Echo())"
    recording, nothing = run_node(spins, short(1.0)), run_node(spins, short(0.003))
    assert came_to_rest(recording) == first_asked(recording) == recording.scans()[0].t
    assert nothing.delivered == ()
    assert came_to_rest(nothing) is first_asked(nothing) is None


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
