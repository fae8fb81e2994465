"""What a node may go on with after a start that is not allowed; and what its answers show."""

import json
from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.case import exactly, spell_allowed
from grader.checks.parameters import ANSWERS, SETTER
from grader.exercises.live_parameters import causes
from grader.exercises.live_parameters.contract import DEFAULTS, _starts, may_be
from sim.messages import string


@pytest.mark.parametrize(
    ("given", "goes_on_with", "not_with"),
    [
        ({"slow_distance": 2.5}, {"slow_distance": 2.5}, {}),
        ({"slow_distance": 2}, {}, {"slow_distance": 2.0}),
        ({"cruise_speed": 3.0}, {"cruise_speed": 0.5}, {"cruise_speed": 3.0}),
        ({"stop_distance": 1.5}, {"slow_distance": 1.5, "stop_distance": 1.5}, {}),
        ({"stop_distance": 1.5}, {"stop_distance": 1.0}, {"stop_distance": 1.5}),
        ({"stop_distance": True, "slow_distance": 3.0}, {"slow_distance": 3.0}, {}),
    ],
)
def test_after_a_start_that_is_not_allowed_it_drives_by_values_that_are(
    given: dict[str, Any], goes_on_with: dict[str, Any], not_with: dict[str, Any]
) -> None:
    starts = list(_starts(given))
    assert DEFAULTS | goes_on_with in starts
    assert all(may_be(each) for each in starts)
    assert not not_with or DEFAULTS | not_with not in starts


def test_an_expected_value_is_said_once() -> None:
    assert spell_allowed(exactly(0.3, 0.15, 0.3), "m/s") == "0.15 m/s or 0.30 m/s"


@pytest.mark.parametrize(
    ("answer", "failed", "said"),
    [
        ({"described": [("speed", True)]}, "declared", "integer_range of a double"),
        ({"described": [("speed", False)]}, "declared", ""),
        ({"accepted": False, "reason": "not close to a valid step"}, "takes_effect", "Leave step"),
        ({"accepted": False, "reason": "returned an invalid type"}, "pairs", "on every path"),
        ({"accepted": False, "reason": "returned an invalid type"}, "wiring", ""),
        ({"accepted": False, "reason": " "}, "pairs", "without a reason"),
        ({"there": ["max_speed"]}, "started", "no slow_distance. What it declares: max_speed"),
        ({"node": "/driver"}, "started", "There is /driver"),
    ],
)
def test_what_ros_says_is_a_cause(answer: dict[str, Any], failed: str, said: str) -> None:
    about = {"type": 3, "limits": [], "description": "speed"}
    described = [{"name": n, "ignored": i, **about} for n, i in answer.pop("described", ())]
    ends = (SimpleNamespace(node=answer.pop("node", "/node")),)
    text = json.dumps({"order": 0, "described": described, **answer})
    program = SimpleNamespace(file=SETTER, arguments=("node", "0.5 speed:=0.1"))
    scenario = SimpleNamespace(program=(program,))
    run: Any = SimpleNamespace(name="live_changed", live=None, scenario=scenario, ends=ends)
    run.published = [string(ANSWERS, 0, text)]
    found = causes.seen({"live_changed": run}, [failed])
    assert said in (found.text if found else "") and bool(found) == bool(said)
