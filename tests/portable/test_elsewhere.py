"""The command `course` on a process that has nothing that only Linux or Unix has."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from grader.course.exercises import all_exercises
from rclpy_virtual_time.link.practice import PRACTICE

ROOT = Path(__file__).resolve().parents[2]
FULL = os.environ.get("COURSE_PORTABLE") == "full"  # make conform: all exercises
SOME = ("trend_memory", "model_server")
ELSEWHERE = Path(__file__).with_name("elsewhere.py")


def course(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command of `course` there."""
    return subprocess.run(
        [sys.executable, str(ELSEWHERE), *arguments],
        cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=570, check=False,
    )  # fmt: skip


def test_it_is_poor_indeed() -> None:
    code = (
        "import sys; sys.path.insert(0, 'tests/portable'); import elsewhere, os, select;"
        "elsewhere.impoverish();"
        "assert not any(hasattr(os, n) for n in ('fork', 'getuid', 'pidfd_open', 'setsid'));"
        "assert not hasattr(select, 'poll');"
        "missing = []\n"
        "for name in ('fcntl', 'resource', 'rclpy_virtual_time.host.sandbox.users',\n"
        "             'rclpy_virtual_time.link.hosts'):\n"
        "    try: __import__(name)\n"
        "    except ImportError: missing.append(name)\n"
        "try: open('/proc/self/stat')\n"
        "except elsewhere.OnlyLinux: missing.append('proc')\n"
        "assert len(missing) == 5, missing"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def test_a_node_is_graded() -> None:
    file = "solutions/obstacle_avoidance/obstacle_avoidance_agent.py"
    done = course("grade", "1", file, "--only", "stop_zone", "--json", "-")
    assert done.returncode == 0, done.stderr
    grading = json.loads(done.stdout)
    assert grading["practice"] == PRACTICE
    assert grading["score"] == grading["max_score"] > 0


@pytest.mark.long
@pytest.mark.parametrize("slug", [e.slug for e in all_exercises()] if FULL else SOME)
def test_every_reference_gets_full_marks(slug: str) -> None:
    done = course("grade", slug, f"solutions/{slug}", "--field", "--json", "-")
    grading = json.loads(done.stdout)
    unjudged = {c["id"] for c in grading["checks"] if c["outcome"] in ("skip", "unavailable")}
    failed = [c["id"] for c in grading["checks"] if c["outcome"] in ("fail", "error")]
    assert (failed, grading["score"]) == ([], grading["max_score"]), unjudged


def test_doctor_explains() -> None:
    done = course("doctor")
    assert done.returncode == 1, done.stderr
    said = " ".join(done.stdout.split())
    assert "The real rclpy can't run here" in said
    assert "portable: rclpy's own Python, for practice" in said and "extra `ml`" in said
    assert "course autograde, --tier 2 and the fixture virtual_time need the real rclpy" in said


def test_a_class_is_refused(tmp_path: Path) -> None:
    done = course("autograde", str(tmp_path), "--out", str(tmp_path / "out"), "--trust")
    assert done.returncode == 2
    assert "course autograde needs Linux" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


MINE = """
def test_it_drives(drive):
    run = drive({file!r}, scenario="demo_wall", duration=2)
    assert len(run.messages("/cmd_vel")) == len(run.scans())


def test_it_waits(virtual_time):
    raise AssertionError
"""


@pytest.mark.long
def test_pytest_has_the_fixture_drive_and_says_what_is_not_there(tmp_path: Path) -> None:
    test = tmp_path / "test_mine.py"
    agent = ROOT / "solutions/obstacle_avoidance/obstacle_avoidance_agent.py"
    test.write_text(MINE.format(file=str(agent)), "utf-8")
    done = course("pytest", "-rs", "-c", os.devnull, str(test))
    said = " ".join(done.stdout.split())
    assert "1 passed, 1 skipped" in said, done.stdout + done.stderr
    assert f"drive: {PRACTICE}" in said
    assert "virtual_time needs the real rclpy" in said


def test_a_notebook_gets_ready_without_the_wheels_of_ros() -> None:
    done = course("prepare")
    said = " ".join(done.stdout.split())
    assert "Ready: " in said, done.stderr
    assert PRACTICE[1:] in said and "has never been run on" in said


def test_an_exercise_is_started_once(tmp_path: Path) -> None:
    command = [sys.executable, str(ELSEWHERE), "start", "2"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    first, second = (
        subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        for _ in range(2)
    )
    assert (first.returncode, second.returncode) == (0, 2), first.stderr
    assert len(course("list", "--scenarios").stdout.splitlines()) > 9
    assert {path.name for path in (tmp_path / "ml_velocity").iterdir()} == {
        "README.md", "hints.md", "glossary.md", "test_ml_velocity.py", "ml_velocity_controller.py",
        "train_velocity_model.py",
    }  # fmt: skip
    assert "ml_velocity is there already" in second.stderr
