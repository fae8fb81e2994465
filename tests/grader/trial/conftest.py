"""A node for a few seconds of real time, on DDS."""

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest
from node_runs import PREAMBLE, short

from grader.course.submission import Submission
from grader.recording import Recording
from grader.trial.real_time import run_live_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import Scenario

RunLive = Callable[..., Recording]


@pytest.fixture
def run_live(forkserver: ForkServer, tmp_path: Path) -> RunLive:
    """Run a few lines of node (after PREAMBLE) in a scenario, in real time."""

    def run(
        source: str, scenario: Scenario | None = None, name: str = "node.py", reason: str = ""
    ) -> Recording:
        file = tmp_path / name
        file.write_text(PREAMBLE + textwrap.dedent(source))
        return run_live_trial(Submission(file), scenario or short(1.0), forkserver, reason=reason)

    return run
