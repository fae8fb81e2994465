"""What the engine's tests share: a warm fork server, and a way to run a few lines of node."""

import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest

from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.programs import ProgramsRun
from rclpy_virtual_time.link.ros_environment import RosEnvironment
from rclpy_virtual_time.link.settings import EPOCH
from rclpy_virtual_time.tests.runs import PREAMBLE, RunNode, run_beside_lidar


@pytest.fixture(scope="session")
def forkserver() -> Iterator[ForkServer]:
    """A warm fork server without libraries."""
    with ForkServer(EPOCH) as server:
        yield server


@pytest.fixture(scope="module", params=["real", "portable"])
def runtime(request: pytest.FixtureRequest, forkserver: ForkServer) -> Iterator[ForkServer]:
    """Have a host with the real rclpy, and with the portable one."""
    if request.param == "real":
        yield forkserver
        return
    with ForkServer(EPOCH, RosEnvironment.portable()) as server:
        yield server


@pytest.fixture
def run_node(forkserver: ForkServer, tmp_path: Path) -> RunNode:
    """Run a few lines of node (after PREAMBLE) beside a lidar."""

    def run(source: str, seconds: float = 2.0, **options: object) -> ProgramsRun:
        (tmp_path / "node.py").write_text(PREAMBLE + textwrap.dedent(source), "utf-8")
        return run_beside_lidar(forkserver, tmp_path, "node.py", seconds=seconds, **options)

    return run
