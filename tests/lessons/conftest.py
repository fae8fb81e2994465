"""What the tests of the lesson share."""

import pytest
from pitfall_runs import Runs

from grader.link.hosts import ForkServer


@pytest.fixture(scope="session")
def runs(forkserver: ForkServer) -> Runs:
    return Runs(forkserver)
