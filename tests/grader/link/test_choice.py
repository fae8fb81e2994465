"""Which launcher a command takes; trials by one that runs anywhere are as by any other."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.course.exercises import ROOT
from grader.course.submission import find_submission
from grader.drive import drive_node, scenario_for
from grader.launchers import why_no_class
from grader.trial.trials import NodeTrials
from rclpy_virtual_time import NoRos, PracticeServer, RosEnvironment
from rclpy_virtual_time.link import practice
from sim.messages import EPOCH_NS


@pytest.fixture(scope="module")
def server() -> Iterator[PracticeServer]:
    with PracticeServer(EPOCH_NS) as started:
        yield started


def no_ros() -> None:
    raise NoRos("ROS 2 Jazzy was not found")


def test_linux_with_ros_takes_the_real_one() -> None:
    assert PracticeServer.why_needed() == ""
    assert why_no_class(trust=False) == ""


def test_without_ros_a_class_needs_trust(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RosEnvironment, "find", no_ros)
    assert PracticeServer.why_needed() == "ROS 2 Jazzy was not found"
    refusal = why_no_class(trust=False)
    assert "for practice only" in refusal and "--trust" in refusal
    assert why_no_class(trust=True) == ""


def test_without_fork_no_class_is_graded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(practice.os, "fork")
    assert "is for Linux" in PracticeServer.why_needed()
    assert why_no_class(trust=True).startswith("course autograde needs Linux")


def test_a_drive_is_the_same_as_on_the_real_rclpy(
    server: PracticeServer, forkserver: PracticeServer
) -> None:
    scenario = scenario_for("demo_wall", duration=3.0)
    submission = find_submission(ROOT / "solutions/obstacle_avoidance/obstacle_avoidance_agent.py")
    digests = {drive_node(submission, scenario, who).digest() for who in (server, forkserver)}
    assert len(digests) == 1


def test_a_node_that_hangs_is_not_run_again_in_real_time(
    server: PracticeServer, tmp_path: Path
) -> None:
    (tmp_path / "agent.py").write_text(
        "import rclpy\nrclpy.init()\nfrom rclpy.experimental import EventsExecutor\n"
        "EventsExecutor()\n", "utf-8"
    )  # fmt: skip
    with NodeTrials(find_submission(tmp_path / "agent.py"), server) as trials:
        recording = trials.get("demo_wall")
    assert recording.outcome.kind == "real_time"
