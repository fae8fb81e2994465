"""Grading in containers without other users: root's name, and no more than an ordinary user."""

import shutil
import subprocess
import sys

import pytest

from grader.course.exercises import find_exercise


def test_root_who_can_be_nobody_else_can_grade() -> None:
    alone = ["unshare", "--map-root-user"]
    if shutil.which("unshare") is None or subprocess.run([*alone, "true"], check=False).returncode:
        pytest.skip("no user namespaces here")
    script = (
        "import os; from rclpy_virtual_time.host.sandbox import users;"
        "print(os.getuid(), users.is_root())"
    )
    said = subprocess.run([*alone, sys.executable, "-c", script], check=True, capture_output=True)
    assert said.stdout.split() == [b"0", b"False"]
    exercise = find_exercise("obstacle_avoidance")
    course = [sys.executable, "-m", "grader.cli", "grade", exercise.slug, "--only", "wiring"]
    done = subprocess.run(
        [*alone, *course, str(exercise.solutions / exercise.files[0])],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, "5 / 5" in done.stdout) == (0, True), done.stdout + done.stderr
