"""What the engine's tests share: a warm fork server."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.settings import EPOCH


@pytest.fixture(scope="session")
def forkserver() -> Iterator[ForkServer]:
    """A warm fork server without libraries."""
    with ForkServer(EPOCH) as server:
        yield server
