"""What the tests of the lesson share."""

import sys

import pytest
from pitfall_runs import Runs

from grader.course.exercises import ROOT
from grader.link.hosts import ForkServer

sys.path.append(str(ROOT / "lessons"))  # the site's module: contract


@pytest.fixture(scope="session")
def runs(forkserver: ForkServer) -> Runs:
    return Runs(forkserver)
