"""Hosts of their own: an attack may harm what they come from."""

from collections.abc import Iterator

import pytest

from grader.launchers import fork_server
from rclpy_virtual_time.link.hosts import ForkServer


@pytest.fixture(scope="module")
def forkserver() -> Iterator[ForkServer]:
    with fork_server() as forkserver:
        yield forkserver
