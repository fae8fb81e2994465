"""When is the way free? Only if it is, wherever a node lets its sector end."""

import numpy as np
import pytest

from grader.course.exercises import find_exercise
from grader.exercises import driving_contract_of as contract_of
from grader.recording import Scan
from sim.scenario import Scenario
from sim.world import World

EMPTY = Scenario(title="", world=World(), duration=1.0)


def scan(angle: int, distance: float, elsewhere: float) -> Scan:
    """Return a scan with one beam that differs; an LDS-01 says 0.0 where nothing comes back."""
    ranges = np.full(360, elsewhere)
    ranges[180 + angle] = distance
    return Scan(
        t=1.0,
        stamp=1.0,
        ranges=ranges,
        angle_min=-np.pi,
        angle_increment=2 * np.pi / 360,
        range_min=0.12,
        range_max=3.5,
    )


@pytest.mark.parametrize("exercise", ["1", "4"])
@pytest.mark.parametrize(
    ("seen", "free"),
    [
        (scan(0, 3.0, 3.0), True),
        (scan(0, 0.3, 3.0), False),
        (scan(0, 3.0, 0.0), True),  # one beam comes back, from far away
        (scan(91, 0.75, 0.0), False),  # nothing usable within ±90°: who stands is right
        (scan(89, 0.75, 0.0), False),  # at the edge: it may or may not count
        (scan(91, 0.3, 3.0), False),
    ],
)
def test_the_way_is_free_if_it_is_for_every_right_sector(
    exercise: str, seen: Scan, free: bool
) -> None:
    found = contract_of(find_exercise(exercise)).free
    assert found is not None
    assert found(EMPTY, seen) is free
