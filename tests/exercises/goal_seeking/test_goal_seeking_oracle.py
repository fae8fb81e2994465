"""Exercise 3: the occasions on which a node has to say something, and what is right there."""

import math

import pytest
from goal_runs import Rows, recorded

from grader.checks.case import Case
from grader.exercises.goal_seeking.contract import cases, seeking

GOAL: Rows = [(0.5, 2.0, 0.0)]
WAY: Rows = [(1.0, 0.0, 0.0, 0.0), (2.0, 1.6, 0.0, 0.0)]
ZERO = 1e-6


def tagged(tag: str, *run: Rows, bench: bool = False) -> list[Case]:
    return [case for case in cases(recorded(*run, bench=bench)) if tag in case.tags]


def right(found: list[Case]) -> list[bool]:
    return [not case.wrong(ZERO) if case.allowed else not case.count for case in found]


@pytest.mark.parametrize(
    ("yaw", "speed", "ok"),
    [(0.0, 0.3, True), (0.0, 0.2, False), (1.0, 0.2, True), (1.0, -0.1, False), (1.0, 0.4, False)],
)
def test_it_may_be_slower_only_while_it_turns(yaw: float, speed: float, ok: bool) -> None:
    pose = [(1.0, 0.0, 0.0, yaw)]
    assert right(tagged("speed", pose, GOAL, [(1.2, speed, 0.0)], bench=True)) == [ok]


def test_a_pose_of_a_bench_without_an_answer_is_silence() -> None:
    (case,) = tagged("speed", [(1.0, 0.0, 0.0, 0.0)], GOAL, [(0.9, 0.3, 0.0)], bench=True)
    assert not case.said


@pytest.mark.parametrize(
    ("yaw", "rate", "ok"),
    [
        *((-1.0, 1.0, [True]), (-1.0, -1.0, [False]), (-1.0, 0.0, [False])),
        *((1.0, -1.0, [True]), (1.0, math.nan, [False]), (0.1, 1.0, []), (3.1, 1.0, [])),
    ],
)
def test_near_ahead_and_behind_either_side_is_right(
    yaw: float, rate: float, ok: list[bool]
) -> None:
    pose = [(1.0, 0.0, 0.0, yaw)]
    assert right(tagged("turn", pose, GOAL, [(1.2, 0.3, rate)], bench=True)) == ok


@pytest.mark.parametrize(
    ("said", "ok"),
    [
        ([(2.1, 0.0, 0.0)], [True, True]),  # that it stops, and then silence
        ([(2.1, 0.0, 0.0), (2.2, 0.0, 0.0)], [True, False]),
        ([(2.1, 0.0, 0.1)], [False, True]),
        ([], [False, True]),
        ([(1.2, 0.0, 0.0)], [False, True]),  # too early
    ],
)
def test_a_stop_is_one_zero_twist_near_the_goal(said: Rows, ok: list[bool]) -> None:
    assert right(tagged("stop", WAY, GOAL, [(1.1, 0.3, 0.0), *said])) == ok


def ticks(speed: float, begin: float, end: float) -> Rows:
    return [(begin + 0.1 * i, speed, 0.0) for i in range(round(10 * (end - begin)))]


@pytest.mark.parametrize(
    ("said", "ok"),
    [
        (ticks(0.3, 1.05, 3.0), True),
        (ticks(0.2, 1.05, 3.0), True),  # a wrong speed is no matter of this
        (ticks(0.3, 1.05, 2.0), False),
        ([], True),
        (ticks(0.3, 2.05, 3.0), False),  # it wakes up
    ],
    ids=["goes on", "wrong", "stops", "silent", "wakes"],
)
def test_a_pose_of_nan_changes_nothing(said: Rows, ok: bool) -> None:
    poses = [(1.0, 0.0, 0.0, 0.0), (2.0, math.nan, 0.0, 0.0)]
    assert right(tagged("bad", poses, GOAL, said)) == [ok]


def test_the_way_ends_on_arrival_and_goes_on_to_a_newer_goal() -> None:
    two = [(0.5, 2.0, 0.0), (1.5, 2.0, 0.1), (3.0, 9.0, 9.0)]
    assert list(seeking(recorded(WAY, two))) == [(1.0, 2.0), (3.0, 6.0)]
