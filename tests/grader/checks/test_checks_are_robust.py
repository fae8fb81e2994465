"""What a node publishes is hostile input: whatever it is, a check fails on it; it never breaks.

A check that breaks (ERROR) is the grader's fault and costs the student nothing, so a message that
breaks a check would be worth publishing. Here recordings of the reference solutions are spoilt in
many ways, and every core check has to come to a verdict on them, also those that would be skipped.
"""

import importlib
import importlib.util
import os
import random
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from spoilt_recordings import WAYS, ended

from grader.checks.case import Runs
from grader.checks.verdict import CheckFailed, Inconclusive
from grader.course.exercises import Exercise, all_exercises
from grader.course.submission import find_submission
from grader.exercises import oracle_of
from grader.launchers import ForkServerPool
from grader.recording import Outcome, Recording
from grader.report.page import json_text
from grader.trial.kept import KeptRecordings
from grader.trial.trials import NodeTrials
from rclpy_virtual_time.link.hosts import ForkServer

EXAMPLES = int(os.environ.get("COURSE_HOSTILE_EXAMPLES", "20"))  # for each exercise
EXERCISES = [exercise.slug for exercise in all_exercises()]
DEATHS = (0.0, 0.1, 1.0)  # [s] in one scenario, and then in the next
QUICK = ("obstacle_avoidance",)  # in `make test`


def core_checks(exercise: Exercise) -> Iterator[Callable[..., None]]:
    """Return the functions of an exercise's core checks."""
    for file in sorted(exercise.judge.glob("test_*.py")):
        module = importlib.import_module(f"grader.exercises.{exercise.slug}.{file.stem}")
        for name, check in vars(module).items():
            if name.startswith("test_") and not mark(check).get("field"):
                yield check


def is_judged_here(check: Callable[..., None]) -> bool:
    return all(importlib.util.find_spec(name) for name in mark(check).get("requires", ()))


def mark(check: Callable[..., None]) -> dict[str, Any]:
    return next(mark.kwargs for mark in check.pytestmark if mark.name == "check")  # type: ignore[attr-defined]


def recordings_of(
    exercise: Exercise, forkserver: ForkServer, checks: list[Any], kept: KeptRecordings
) -> dict[str, Recording]:
    """Return what the reference does in every scenario of these checks."""
    file = exercise.solutions / exercise.files[0]
    submission = find_submission(file, exercise.files[0], exercise.files[1:])
    names = list(dict.fromkeys(name for check in checks for name in mark(check)["scenarios"]))
    with NodeTrials(submission, forkserver, kept=kept) as trials:
        trials.prepare(names)
        return {name: trials.get(name) for name in names}


def verdict(check: Callable[..., None], exercise: Exercise, recordings: list[Recording]) -> str:
    """Return what a student reads; empty for a pass. Any other exception breaks the check."""
    try:
        check(Runs(recordings, oracle_of(exercise), exercise.slug))
    except CheckFailed as failed:
        said = [failed.message, failed.expected, failed.actual, failed.help]
        assert all(isinstance(text, str) for text in said), said
        return json_text({"said": said, "time": failed.at, "scenario": failed.scenario})
    except Inconclusive as unclear:
        return str(unclear)
    return ""


@pytest.mark.parametrize(
    "slug",
    [pytest.param(slug, marks=() if slug in QUICK else pytest.mark.long) for slug in EXERCISES],
)
def test_no_message_breaks_a_check(
    slug: str, forkservers: ForkServerPool, recordings: KeptRecordings, pytestconfig: pytest.Config
) -> None:
    pytestconfig.addinivalue_line("markers", "check: a check of the grader")
    exercise = next(exercise for exercise in all_exercises() if exercise.slug == slug)
    checks = [check for check in core_checks(exercise) if is_judged_here(check)]
    servers = forkservers.of(exercise.libraries)
    recorded = recordings_of(exercise, servers, checks, recordings)

    def every_check_judges(recordings: dict[str, Recording], of: str = "") -> None:
        for check in checks:
            names = mark(check)["scenarios"]
            if not of or of in names:
                verdict(check, exercise, [recordings[name] for name in names])

    for name, at in product(recorded, DEATHS):
        dead = ended(recorded[name], Outcome("died", "killed by signal 9", at, ""))
        every_check_judges({**recorded, name: dead}, of=name)

    @settings(
        derandomize=True,
        deadline=None,
        max_examples=EXAMPLES,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(way=st.sampled_from(sorted(WAYS)), seed=st.integers(0, 2**32 - 1))
    def every_check_comes_to_a_verdict(way: str, seed: int) -> None:
        rng = random.Random(seed)
        every_check_judges({name: WAYS[way](one, rng) for name, one in recorded.items()})

    every_check_comes_to_a_verdict()
