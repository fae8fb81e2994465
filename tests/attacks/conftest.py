"""Hosts of their own: an attack may harm what they come from."""

from collections.abc import Iterator

import pytest

from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS


@pytest.fixture(scope="module")
def forkserver() -> Iterator[ForkServer]:
    with ForkServer(EPOCH_NS) as forkserver:
        yield forkserver
