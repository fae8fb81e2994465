"""Exercise 7's rules: which decisions are right, and why."""

import math
from dataclasses import replace
from typing import Any

import pytest

from grader.exercises.safety_supervisor.rules import Decision, Situation, decisions

NAN = (math.nan, 0.0, 0.0, 0.0, 0.0, 0.0)
FREE = Situation(False, (0.5, 0.0, 0.0, 0.0, 0.0, 1.9), 0.1, (2.0,), 0.1)


@pytest.mark.parametrize(
    ("situation", "right"),
    [
        (FREE, {"ok"}),
        (replace(FREE, e_stop=True, raw=NAN, command_age=9.0), {"e_stop"}),
        (replace(FREE, raw=NAN, command_age=9.0, scan_age=9.0), {"bad_command"}),
        (replace(FREE, raw=None, command_age=math.inf, scan_age=9.0), {"stale_command"}),
        (replace(FREE, command_age=0.56), {"stale_command"}),
        (replace(FREE, command_age=0.44), {"ok"}),
        (replace(FREE, command_age=0.52), {"stale_command", "ok"}),
        (replace(FREE, distances=(0.4,), raw=(0.8, 0.0, 0.0, 0.0, 0.0, 3.0)), {"obstacle"}),
        (replace(FREE, distances=(0.5,)), {"ok"}),
        (replace(FREE, distances=(0.5005,)), {"obstacle", "ok"}),
        (replace(FREE, distances=(0.4,), raw=(-0.8, 0.0, 0.0, 0.0, 0.0, 0.0)), {"limited"}),
    ],
)
def test_the_first_rule_that_matches_gives_the_reason(
    situation: Situation, right: set[str]
) -> None:
    assert {decision.reason for decision in decisions(situation, last=0.5)} == right


def test_just_as_asked_and_just_limited_look_alike() -> None:
    asked = replace(FREE, raw=(0.145, 0.0, 0.0, 0.0, 0.0, 1.9))
    assert {decision.reason for decision in decisions(asked, last=0.1)} == {"ok", "limited"}


@pytest.mark.parametrize(
    ("situation", "right"),
    [
        ({"e_stop": True}, Decision("e_stop")),
        ({"distances": (0.4,)}, Decision("obstacle", 0.0, 1.9)),
        ({}, Decision("limited", 0.045, 1.9, rising=True)),
    ],
)
def test_a_reason_gives_the_command(situation: dict[str, Any], right: Decision) -> None:
    too_much = replace(FREE, raw=(0.8, 0.0, 0.0, 0.0, 0.0, 3.0), **situation)
    assert list(decisions(too_much, last=0.0)) == [right]
