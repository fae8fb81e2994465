"""The nearest usable reading ahead, whatever the lidar's layout."""

import math

import numpy as np
import pytest

from grader.checks.ahead import front_distance
from grader.recording import Scan

EVERY_DEGREE = np.arange(-180, 180)


def scan(readings: dict[int, float], first: int = -180, elsewhere: float = 3.0) -> Scan:
    """360 beams, one a degree; these angles [°] read these distances [m]."""
    degrees = first + np.arange(360)
    wrapped = (degrees + 180) % 360 - 180
    ranges = [readings.get(int(angle), elsewhere) for angle in wrapped]
    return Scan(
        t=0.0,
        stamp=0.0,
        angle_min=math.radians(first),
        angle_increment=math.radians(1),
        range_min=0.12,
        range_max=3.5,
        ranges=np.array(ranges, np.float32),
    )


@pytest.mark.parametrize("first", [-180, 0])  # an LDS-01 begins ahead and wraps round
@pytest.mark.parametrize(
    ("readings", "distance"),
    [
        ({0: 1.0, 20: 0.7}, 0.7),
        ({85: 0.6}, 0.6),
        ({-85: 0.6}, 0.6),
        ({95: 0.3, 180: 0.2, -95: 0.3}, 3.0),  # behind
        ({0: math.nan, 10: 0.05, 20: 9.0}, 3.0),  # unusable
        ({0: -math.inf}, 0.0),
    ],
)
def test_the_nearest_usable_reading_ahead_counts(
    readings: dict[int, float], distance: float, first: int
) -> None:
    assert front_distance(scan(readings, first)) == pytest.approx(distance)


def test_nothing_in_range_is_infinitely_far() -> None:
    assert front_distance(scan({}, elsewhere=math.inf)) == math.inf


def test_without_a_usable_reading_ahead_there_is_no_distance() -> None:
    behind = {int(angle): 1.0 for angle in EVERY_DEGREE if abs(angle) > 95}
    assert front_distance(scan(behind, elsewhere=math.nan)) is None


def test_the_half_angle_says_what_is_ahead() -> None:
    here = scan({89: 0.4})
    assert front_distance(here, 90.0) == pytest.approx(0.4)
    assert front_distance(here, 88.5) == pytest.approx(3.0)
