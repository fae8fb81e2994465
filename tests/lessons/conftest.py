"""What the tests of the lesson share."""

import sys

import pytest
from pitfall_runs import Runs

from grader.course.exercises import ROOT
from rclpy_virtual_time.link.hosts import ForkServer

# The site's modules: contract, and its extensions
sys.path += [str(ROOT / "lessons"), str(ROOT / "lessons" / "_ext")]


@pytest.fixture(scope="session")
def runs(forkserver: ForkServer) -> Runs:
    return Runs(forkserver)
