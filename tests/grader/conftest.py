"""The real thing for tests: a way to run a few lines of node."""

import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest
from node_runs import PREAMBLE, RunNode, short

from grader.course.submission import Submission
from grader.launchers import fork_server
from grader.recording import Recording
from grader.trial.virtual_time import Limits, run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.ros_environment import RosEnvironment
from sim.scenario import Scenario


@pytest.fixture(scope="session")
def short_scenario() -> Scenario:
    """Two seconds of a lidar at 10 Hz; no odometry."""
    return short(2.0)


@pytest.fixture(scope="module", params=["real", "portable"])
def runtime(request: pytest.FixtureRequest, forkserver: ForkServer) -> Iterator[ForkServer]:
    """Have a host with the real rclpy, and with the portable one."""
    if request.param == "real":
        yield forkserver
        return
    with fork_server(RosEnvironment.portable()) as server:
        yield server


@pytest.fixture
def run_node(forkserver: ForkServer, short_scenario: Scenario, tmp_path: Path) -> RunNode:
    """Run a few lines of node (after PREAMBLE) in a scenario."""

    def run(source: str | bytes, scenario: Scenario | None = None, **options: object) -> Recording:
        file = tmp_path / "node.py"
        if isinstance(source, str):
            source = (PREAMBLE + textwrap.dedent(source)).encode()
        file.write_bytes(source)
        options.setdefault("limits", Limits(start=20.0, step=5.0, total=60.0))
        return run_trial(Submission(file), scenario or short_scenario, forkserver, **options)

    return run
