"""Trials on the portable runtime: as on the real rclpy, and never in real time."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.course.exercises import ROOT
from grader.course.submission import find_submission
from grader.drive import drive_node, scenario_for
from grader.trial.trials import NodeTrials
from rclpy_virtual_time import PracticeServer
from sim.messages import EPOCH_NS
from sim.scenario_files import load_scenario


@pytest.fixture(scope="module")
def server() -> Iterator[PracticeServer]:
    with PracticeServer(EPOCH_NS) as started:
        yield started


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
        recording = trials.get(load_scenario("demo_wall").name)
    assert recording.outcome.kind == "real_time"
