"""What to look at next: a wrong sign and missing digits are named."""

import pytest

from grader.checks.case import Case
from grader.exercises.trend_memory.words import slip


@pytest.mark.parametrize(
    ("value", "said"),
    [(-1.121, "sign"), (1.1, "rounded"), (1.0, "rounded"), (-1.0, ""), (0.0, ""), (1.121, "")],
)
def test_a_wrong_closing_speed_is_explained(value: float, said: str) -> None:
    advice = slip(Case(0.0, "scan 10", allowed={"data": ((1.1205, 1.1215),)}, said={"data": value}))
    assert said in advice
    assert bool(advice) is bool(said)
