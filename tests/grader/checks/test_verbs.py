"""The verbs of the checks: the answer of each, for cases and recordings made by hand."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.case import Case, Runs, exactly
from grader.checks.verbs import every, follows, require_allowed
from grader.checks.verdict import CheckFailed
from grader.recording import Outcome

NEAR = Case(1.0, "a wall 0.42 m ahead", frozenset({"stop"}), {"linear.x": exactly(0.0)})
FREE = Case(2.0, "3.00 m ahead", frozenset({"clear"}), {"linear.x": exactly(0.5)})


def recording(**parts: Any) -> Any:
    whole = {
        "name": "trial", "outcome": Outcome("completed"), "duration_s": 3.0, "log": (),
        "scenario": SimpleNamespace(bench_scans=[1]), "slack": 0.0, "delivered": (), "judged": {},
    }  # fmt: skip
    return SimpleNamespace(**{**whole, **parts})


def said(case: Case, speed: float, count: int = 1) -> Case:
    return replace(case, said={"linear.x": speed}, count=count)


@pytest.mark.parametrize(
    ("case", "message", "actual"),
    [
        (NEAR, "a wall 0.42 m ahead: no command came", "none"),
        (said(NEAR, 0.5), "a wall 0.42 m ahead: wrong linear.x", "linear.x = 0.50 m/s"),
        (
            said(NEAR, 0.5, count=0),
            "a wall 0.42 m ahead: no command came",
            "none; the last one, linear.x = 0.50 m/s, still counts",
        ),
        (
            Case(1.0, "before the first goal", count=2),
            "before the first goal: a command came",
            "2 of them",
        ),
    ],
)
def test_what_is_not_allowed_is_said_with_what_was_expected(
    case: Case, message: str, actual: str
) -> None:
    with pytest.raises(CheckFailed) as caught:
        require_allowed(recording(), case)
    assert (caught.value.message, caught.value.actual, caught.value.at) == (message, actual, 1.0)


@pytest.mark.parametrize(
    ("topic", "count", "help"),
    [("/cmd_vel", 0, "Publish once"), ("/cmd_vel", 1, "A wrong"), ("/speed", 0, "What keeps it")],
)
def test_of_what_did_not_come_no_number_is_explained(topic: str, count: int, help: str) -> None:
    with pytest.raises(CheckFailed) as caught:
        require_allowed(recording(), replace(NEAR, count=count), "A wrong sign?", topic=topic)
    assert caught.value.help.startswith(help)


def test_a_tolerance_beyond_the_period_is_told_as_the_longest_gap() -> None:
    with pytest.raises(CheckFailed) as caught:
        every(recording(times=lambda _: np.array([2.0])), "/cmd_vel", 0.05, 0.075)
    assert caught.value.expected == "one every 50 ms, no gap over 125 ms"


def test_an_answer_within_the_tolerance_is_right() -> None:
    require_allowed(recording(), said(NEAR, 0.0005))


def runs(*cases: Case) -> Runs:
    return Runs([recording()], lambda _: cases)


def test_only_the_occasions_of_a_tag_are_asked() -> None:
    cases = runs(said(NEAR, 0.0), said(FREE, 0.4))
    follows(cases, "stop")
    with pytest.raises(CheckFailed, match=r"3\.00 m ahead: wrong linear\.x"):
        follows(cases, "clear")


def test_a_tag_that_names_nothing_fails() -> None:
    with pytest.raises(CheckFailed, match="no occasion to judge “slow”"):
        follows(runs(said(NEAR, 0.0)), "slow")


def test_a_node_that_says_the_same_whatever_it_sees_gains_nothing() -> None:
    with pytest.raises(CheckFailed, match="the node says the same whatever it sees") as caught:
        follows(runs(said(NEAR, 0.0), said(FREE, 0.0)), "stop")
    assert caught.value.at == 2.0
    assert caught.value.actual == "linear.x = 0.00"
