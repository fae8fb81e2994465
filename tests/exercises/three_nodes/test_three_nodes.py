"""The launch file may take its parameters from a YAML file that lies beside it."""

import shutil
from pathlib import Path

from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from rclpy_virtual_time.link.hosts import ForkServer

YAML = """
/shuttle/driver:
  ros__parameters: {cruise_speed: 0.4, stop_distance: 0.6}
/shuttle/guard:
  ros__parameters: {max_speed: 0.25}
"""


def test_parameters_may_stand_in_a_file(tmp_path: Path, forkserver: ForkServer) -> None:
    exercise = find_exercise("three_nodes")
    for file in exercise.files:
        shutil.copyfile(exercise.solutions / file, tmp_path / file)
    launch = tmp_path / "robot_launch.py"
    text = launch.read_text("utf-8")
    for given in ('{"cruise_speed": 0.4, "stop_distance": 0.6}', '{"max_speed": 0.25}'):
        assert given in text
        text = text.replace(given, '"robot.yaml"')
    launch.write_text(text, "utf-8")
    for yaml, passed in ((YAML, True), (YAML.replace("0.25", "0.2"), False)):
        (tmp_path / "robot.yaml").write_text(yaml, "utf-8")
        submission = find_submission(tmp_path / "guard.py", exercise.files[0], exercise.files[1:])
        grading = grade_submission(
            exercise, submission, forkserver, file="robot_launch.py", only=["parameters"]
        )
        outcome = {check.id: check.outcome for check in grading.checks}
        assert (outcome["parameters"] == "pass") == passed
