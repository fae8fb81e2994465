"""Exercise 7's oracle forgives, in the checks of other rules, what one rule alone is about."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.exercises.safety_supervisor.contract import (
    Decision,
    Situation,
    Tick,
    is_settled,
    never_reverses,
)

NOTHING = Situation(False, (0.5, 0.0, 0.0, 0.0, 0.0, 1.9), 0.1, (2.0,), 0.1)
RISING = Decision("limited", speed=0.145, turn_rate=1.9, wish=0.5, last=0.1)
BACK = Decision("ok", speed=-0.5, turn_rate=0.0, wish=-0.5)


def tick(speed: float, turn_rate: float, *right: Decision, same_for: float = 0.0) -> Tick:
    values = (speed, 0.0, 0.0, 0.0, 0.0, turn_rate)
    return Tick(1.0, values, NOTHING, right, (), same_for, rising_lately=True)


@pytest.mark.parametrize(
    ("speed", "strict", "forgiven"),
    [(0.145, True, True), (0.3, False, True), (0.5, False, True), (0.6, False, False),
     (0.12, False, True), (0.05, False, False), (0.0, False, False), (float("nan"), False, False)],
)  # fmt: skip
def test_a_rise_that_is_too_fast_or_too_slow_is_one_mistake(
    speed: float, strict: bool, forgiven: bool
) -> None:
    one = tick(speed, 1.9, RISING)
    assert (one.is_right, one.is_right_but_for_the_rise) == (strict, forgiven)


def test_a_wrong_turn_is_not_forgiven() -> None:
    assert not tick(0.3, 0.0, RISING).is_right_but_for_the_rise


def test_to_stand_is_not_to_rise_slowly() -> None:
    first = Decision("limited", speed=0.045, turn_rate=1.9, wish=0.5)
    assert tick(0.01, 1.9, first).is_right_but_for_the_rise
    assert not tick(0.0, 1.9, first).is_right_but_for_the_rise


def test_zero_is_zero_where_a_rule_says_so() -> None:
    assert not tick(0.0005, 0.0, Decision("obstacle")).is_right
    assert not tick(0.0, 0.0005, Decision("e_stop")).is_right
    asked_for_nothing = tick(0.0005, 0.0, Decision("ok"))
    assert asked_for_nothing.is_right
    assert not asked_for_nothing.is_exact  # so it may say limited


def test_never_reversing_is_one_mistake() -> None:
    forwards, backwards = said(0.1, 0.0), said(0.1, -0.045)
    assert never_reverses(tick(0.0, 0.0, BACK), forwards)
    assert not never_reverses(tick(-0.045, 0.0, BACK), forwards)
    assert not never_reverses(tick(0.0, 0.0, RISING), forwards)
    assert not never_reverses(tick(0.0, 0.0, BACK), backwards)  # so it was late


def said(*speeds: float) -> Any:
    """Return a recording of a node that commanded these speeds [m/s]."""
    values = np.array([(speed, 0.0, 0.0, 0.0, 0.0, 0.0) for speed in speeds])
    return SimpleNamespace(twists=lambda: SimpleNamespace(values=values))


def test_whether_it_moves_and_has_to() -> None:
    stop = Decision("e_stop")
    assert tick(0.0, 1.9, RISING).must_move
    assert not tick(0.0, 0.0, RISING, stop).must_move
    assert not tick(float("nan"), 0.0, RISING).moves
    assert tick(0.0, -0.1, RISING).moves


def test_settled_is_when_a_speed_is_reached() -> None:
    assert not is_settled(tick(0.1, 0.0, RISING, same_for=0.55))
    assert is_settled(tick(0.1, 0.0, RISING, same_for=0.6))
