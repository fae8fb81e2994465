"""Launch files: parameters from a YAML file, what is not read here, and what is wrong."""

import re
import shutil
from pathlib import Path

import pytest

from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.drive import drive_in
from grader.grading.grading import Grading, grade_submission
from grader.report.graph import graph_html
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario_files import load_scenario

EXERCISE = find_exercise("three_nodes")
YAML = """
/shuttle/driver:
  ros__parameters: {cruise_speed: 0.4, stop_distance: 0.6}
/shuttle/guard:
  ros__parameters: {max_speed: 0.25}
"""


OF_PROGRAMS = ("distance", "wishes", "limits", "silence")


def solution(tmp_path: Path) -> Path:
    """Lay the solution there; return its launch file."""
    for file in EXERCISE.files:
        shutil.copyfile(EXERCISE.solutions / file, tmp_path / file)
    return tmp_path / "robot_launch.py"


def graded(folder: Path, forkserver: ForkServer, *only: str) -> Grading:
    submission = find_submission(folder / "guard.py", EXERCISE.files[0], EXERCISE.files[1:])
    return grade_submission(EXERCISE, submission, forkserver, file="robot_launch.py", only=only)


@pytest.mark.parametrize(
    ("before", "after", "outcome", "said"),
    [
        ('executable="guard",', 'executable="guard", prefix="nice",', "inconclusive",
         "line 32: Node(prefix=…) is not known here"),
        ('executable="guard",', 'executable="guard", namspace="shuttle",', "fail",
         "line 32: Node has no argument namspace: is namespace meant?"),
        ('[("scan", "/scan")]', '("scan", "/scan")', "fail",
         "line 19: Node(remappings=…) takes a list of pairs"),
        ('("scan", "/scan")', '("scan", "/scan ")', "fail", "expected two names without blanks"),
        ("return LaunchDescription", "LaunchDescription", "fail", "returns nothing"),
        ("from launch_ros.actions", "from rclpy.node", "fail", "this Node is rclpy's"),
    ],
)  # fmt: skip
def test_programs_are_judged_whatever_the_launch_file_is(
    before: str, after: str, outcome: str, said: str, tmp_path: Path, forkserver: ForkServer
) -> None:
    launch = solution(tmp_path)
    text = launch.read_text("utf-8")
    launch.write_text(text.replace(before, after), "utf-8")
    checks = {check.id: check for check in graded(tmp_path, forkserver).checks}
    assert said in checks["nodes"].message
    for name, check in checks.items():
        assert check.outcome == ("pass" if name in OF_PROGRAMS else outcome), name


def test_the_graph_of_the_solution(tmp_path: Path, forkserver: ForkServer) -> None:
    submission = find_submission(solution(tmp_path), others=EXERCISE.files)
    graph = graph_html(drive_in(submission, load_scenario("shuttle_wall"), forkserver))
    plain = [re.sub(r"<wbr>|<span>.*?</span>", "", row) for row in graph.split("<tr>")[2:]]
    assert [re.findall(r'(?:row"|<p)>([^<]+)', row) for row in plain] == [
        ["/scan", "the robot", "/shuttle/watcher"],
        ["/shuttle/distance", "/shuttle/watcher", "/shuttle/driver"],
        ["/shuttle/cmd_vel_raw", "/shuttle/driver", "/shuttle/guard"],
        ["/cmd_vel", "/shuttle/guard", "the robot"],
    ]
    assert "is-bad" not in graph


def test_what_died_is_said_first_with_its_line(tmp_path: Path, forkserver: ForkServer) -> None:
    solution(tmp_path)
    watcher = tmp_path / "watcher.py"
    text = watcher.read_text("utf-8")
    watcher.write_text(text.replace("Float64(data=distance)", "Float64(distance)"), "utf-8")
    grading = graded(tmp_path, forkserver)
    assert grading.cause is not None
    assert grading.cause.where.startswith("line 44 of watcher.py, in scan_callback")
    assert "takes its fields by name" in grading.cause.text
    failed = [check.id for check in grading.checks if check.outcome == "fail"]
    assert failed == ["distance", "keeps_distance"]


def test_parameters_may_stand_in_a_file(tmp_path: Path, forkserver: ForkServer) -> None:
    launch = solution(tmp_path)
    text = launch.read_text("utf-8")
    for given in ('{"cruise_speed": 0.4, "stop_distance": 0.6}', '{"max_speed": 0.25}'):
        assert given in text
        text = text.replace(given, '"robot.yaml"')
    launch.write_text(text, "utf-8")
    for yaml, passed in ((YAML, True), (YAML.replace("0.25", "0.2"), False)):
        (tmp_path / "robot.yaml").write_text(yaml, "utf-8")
        grading = graded(tmp_path, forkserver, "parameters")
        outcome = {check.id: check.outcome for check in grading.checks}
        assert (outcome["parameters"] == "pass") == passed
