"""What to look at next: a speed that no zone has is not blamed on a zone's limit."""

import pytest

from grader.checks.case import Case
from grader.exercises.obstacle_avoidance.test_core import no_zone


@pytest.mark.parametrize(
    ("speed", "said"), [(-0.5, "-0.50"), (100.0, "100.00"), (0.15, ""), (0.0, "")]
)
def test_a_speed_of_no_zone_is_not_blamed_on_a_zones_limit(speed: float, said: str) -> None:
    advice = no_zone(Case(0.0, "a wall", said={"linear.x": speed}))
    assert (f"No zone has a speed of {said} m/s" in advice) is bool(said)
