"""The oracle of exercise 4: what each scan asks of a memory of ten readings."""

import math

import numpy as np
import pytest

from grader.exercises.trend_memory.contract import Step, steps
from grader.recording import Scan

COMING = [(1.7e9 + 0.1 * i, 5.0 - 0.05 * i) for i in range(12)]  # at 0.5 m/s


def asked(readings: list[tuple[float, float]]) -> list[Step]:
    """Return what scans with these stamps [s] and distances [m] ask for."""
    return steps(
        Scan(
            t=stamp,
            stamp=stamp,
            ranges=np.full(360, distance, np.float32),
            angle_min=-math.pi,
            angle_increment=math.tau / 360,
            range_min=0.15,
            range_max=12.0,
        )
        for stamp, distance in readings
    )


def test_ten_equal_stamps_ask_for_nothing() -> None:
    found = asked([(1.7e9, distance) for _, distance in COMING])
    assert {step.due for step in found[9:]} == {None}


@pytest.mark.parametrize("unusable", [math.nan, math.inf])
def test_a_gap_is_one_between_scans_or_between_readings(unusable: float) -> None:
    """Both memories are right, so nothing is asked until they agree again."""
    blind = [(1.7e9 + 1.2 + 0.1 * i, unusable) for i in range(12)]
    later = [(1.7e9 + 2.4 + 0.1 * i, 4.0 - 0.05 * i) for i in range(10)]
    found = asked([*COMING, *blind, *later])
    assert {step.due for step in found[12:24]} == {False}
    assert {step.due for step in found[24:33]} == {None}
    assert found[33].due


@pytest.mark.parametrize("shift", [-0.2, 1.1])
def test_a_jump_of_the_stamps_is_forgotten_by_both(shift: float) -> None:
    later = [(stamp + 1.1 + shift, distance) for stamp, distance in COMING]
    found = asked([*COMING, *later])
    assert [step.forgotten for step in found[12:]] == [True] * 9 + [False] * 3
    assert found[12].due is False and found[21].due
