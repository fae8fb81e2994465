"""The nearest distance ahead is kept by all that it depends on, not by the readings alone."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.checks.ahead import front_distance
from grader.recording import Scan

READINGS = np.full(360, 2.0, np.float32)
READINGS[[180, 240]] = 0.1, 1.0  # ahead, and 60° to the left
SCAN = Scan(0.0, 0.0, -math.pi, math.radians(1), 0.12, 3.5, READINGS)


@pytest.mark.parametrize(
    ("other", "half_angle", "nearest"),
    [
        ({}, 90.0, 1.0),
        ({}, 45.0, 2.0),
        ({"range_min": 0.05}, 90.0, 0.1),
        ({"range_max": 0.5}, 90.0, None),
        ({"angle_min": 0.0}, 90.0, 2.0),
        ({"angle_increment": math.radians(0.3)}, 90.0, 2.0),
        ({"ranges": READINGS + np.float32(0.5)}, 90.0, 0.6),
    ],
)
def test_each_of_what_it_depends_on_counts(
    other: dict[str, Any], half_angle: float, nearest: float | None
) -> None:
    assert front_distance(SCAN) == 1.0
    found = front_distance(replace(SCAN, **other), half_angle)
    assert found == (None if nearest is None else pytest.approx(nearest))
