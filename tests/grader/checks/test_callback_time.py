"""Whose fault a late callback is: the node's that computes or waits; the machine's with a queue."""

import contextlib
import importlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed, Inconclusive
from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.recording import Compute, Recording
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario_files import load_scenario

EXERCISE = find_exercise("obstacle_avoidance")


@pytest.fixture(scope="module")
def check(pytestconfig: pytest.Config) -> Callable[[tuple[Recording, ...]], None]:
    pytestconfig.addinivalue_line("markers", "check: a check of the grader")
    name = f"grader.exercises.{EXERCISE.slug}.test_core"
    return importlib.import_module(name).test_callback_time  # type: ignore[no-any-return]


@pytest.fixture(scope="module")
def recordings(forkserver: ForkServer) -> tuple[Recording, ...]:
    file = EXERCISE.solutions / EXERCISE.files[0]
    names = ("avoid_wall", "avoid_corridor")
    return tuple(run_trial(Submission(file), load_scenario(n), forkserver) for n in names)


def taking(
    recordings: tuple[Recording, ...], cpu: float, queued: float, every: int
) -> tuple[Recording, ...]:
    """Let each `every`-th exchange take 0.15 s, of which so much was spent like this [s]."""
    changed = []
    for recording in recordings:
        time = recording.compute.time
        late = np.arange(len(time)) % every == 0
        parts = (np.where(late, part, 0.001) for part in (0.15, cpu))
        compute = Compute(time, *parts, np.where(late, queued, 0.0))
        changed.append(replace(recording, compute=compute))
    return tuple(changed)


@pytest.mark.parametrize(
    ("cpu", "queued", "every", "verdict"),
    [
        (0.15, 0.0, 20, CheckFailed),  # computes
        (0.001, 0.0, 1, CheckFailed),  # waits in native code, always
        (0.001, 0.0, 5, CheckFailed),  # or often
        (0.001, 0.14, 1, Inconclusive),  # queues for a CPU
        (np.nan, 0.15, 1, Inconclusive),  # in a page nobody counts either
        (0.001, 0.0, 20, Inconclusive),  # now and then, nobody knows why
        (0.15, 0.0, 10_000, None),
    ],
)
def test_late_callbacks(
    check: Callable[[tuple[Recording, ...]], None],
    recordings: tuple[Recording, ...],
    cpu: float,
    queued: float,
    every: int,
    verdict: type[Exception] | None,
) -> None:
    with pytest.raises(verdict) if verdict else contextlib.nullcontext():
        check(taking(recordings, cpu, queued, every))


@pytest.mark.parametrize("later", [0.05, 0.0])  # [s] after the scan; 0: it asks the judge
@pytest.mark.parametrize(
    ("cpu", "queued", "fails"), [(0.09, 0.0, True), (0.001, 0.0, True), (0.001, 0.089, False)]
)
def test_a_callback_can_not_be_put_off_to_another_messages_turn(
    check: Callable[[tuple[Recording, ...]], None],
    recordings: tuple[Recording, ...],
    cpu: float,
    queued: float,
    fails: bool,
    later: float,
) -> None:
    changed = []
    for recording in recordings:
        scans = recording.times("/scan")
        time = np.repeat(scans, 3)
        time[1::3] += later
        time[2::3] += later
        parts = (np.where(np.arange(len(time)) % 3, part, 0.001) for part in (0.09, cpu, queued))
        changed.append(replace(recording, compute=Compute(time, *parts)))
    with pytest.raises(CheckFailed) if fails else contextlib.nullcontext():
        check(tuple(changed))
