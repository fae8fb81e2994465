"""The same node in the same scenario gives the same recording, however busy the machine is."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from grader.course.exercises import SOLUTIONS
from grader.course.submission import Submission
from grader.link.hosts import ForkServer
from grader.trial.virtual_time import run_trial
from sim.scenario_files import load_scenario

AVOIDANCE = SOLUTIONS / "obstacle_avoidance"
NODES = {
    "the reference": AVOIDANCE / "obstacle_avoidance_agent.py",
    "a MultiThreadedExecutor": AVOIDANCE / "variants" / "multithreaded_groups.py",
    "a worker thread": AVOIDANCE / "variants" / "worker_thread_queue.py",
}


@contextmanager
def busy_machine() -> Iterator[None]:
    """Two processes that do nothing, as fast as they can."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


@pytest.mark.parametrize(
    "node",
    [
        pytest.param(node, marks=() if node == "the reference" else pytest.mark.long)
        for node in NODES
    ],
)
def test_six_runs_are_one(node: str, forkserver: ForkServer) -> None:
    submission, scenario = Submission(Path(NODES[node])), load_scenario("avoid_store")
    quiet = [run_trial(submission, scenario, forkserver) for _ in range(3)]
    with busy_machine():
        loaded = [run_trial(submission, scenario, forkserver) for _ in range(3)]

    assert {recording.outcome.kind for recording in quiet + loaded} == {"completed"}
    assert len({recording.digest() for recording in quiet + loaded}) == 1
    assert len(quiet[0].published) > 100
