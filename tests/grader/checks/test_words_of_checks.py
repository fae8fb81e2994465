"""The words of the checks: what each says, of occasions and recordings made by hand."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.case import Case, Runs, exactly
from grader.checks.verdict import CheckFailed
from grader.checks.words import every, follows, logs, require_allowed, silent
from grader.link.log import LogLine
from grader.recording import Outcome

NEAR = Case(1.0, "a wall 0.42 m ahead", frozenset({"stop"}), {"linear.x": exactly(0.0)})
FREE = Case(2.0, "3.00 m ahead", frozenset({"clear"}), {"linear.x": exactly(0.5)})


def recording(**parts: Any) -> Any:
    whole = {
        "name": "trial", "outcome": Outcome("completed"), "duration_s": 3.0, "log": (),
        "scenario": SimpleNamespace(bench_scans=[1]), "slack": 0.0, "delivered": (),
    }  # fmt: skip
    return SimpleNamespace(**{**whole, **parts})


def said(case: Case, speed: float, count: int = 1) -> Case:
    return replace(case, said={"linear.x": speed}, count=count)


@pytest.mark.parametrize(
    ("case", "message", "actual"),
    [
        (NEAR, "a wall 0.42 m ahead: there was still no command", "nothing on /cmd_vel"),
        (said(NEAR, 0.5), "a wall 0.42 m ahead: wrong linear.x", "linear.x = 0.50 m/s"),
        (
            said(NEAR, 0.5, count=0),
            "a wall 0.42 m ahead: no command came, and the last one still counts",
            "none; it is still linear.x = 0.50 m/s",
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


def test_an_answer_within_the_tolerance_is_right() -> None:
    require_allowed(recording(), said(NEAR, 0.0005))


def runs(*cases: Case) -> Runs:
    return Runs([recording()], lambda _: cases)


def test_only_the_occasions_of_a_tag_are_asked() -> None:
    cases = runs(said(NEAR, 0.0), said(FREE, 0.4))
    follows(cases, "stop")
    with pytest.raises(CheckFailed, match=r"3\.00 m ahead: wrong linear\.x"):
        follows(cases, "clear")


def test_a_tag_that_names_nothing_is_the_checks_fault() -> None:
    with pytest.raises(LookupError, match="no occasion 'slow' in trial"):
        follows(runs(said(NEAR, 0.0)), "slow")


def test_a_node_that_says_the_same_whatever_it_sees_gains_nothing() -> None:
    with pytest.raises(CheckFailed, match="the node says the same whatever it sees") as caught:
        follows(runs(said(NEAR, 0.0), said(FREE, 0.0)), "stop")
    assert caught.value.at == 2.0
    assert caught.value.actual == "linear.x = 0.00"


def timed(*times: float) -> Any:
    return recording(times=lambda topic: np.array(times))


def test_silence_is_broken_by_the_first_message() -> None:
    silent(timed(0.5, 2.5), "/cmd_vel", 1.0, 2.0, what="no goal yet")
    with pytest.raises(CheckFailed) as caught:
        silent(timed(0.5, 1.5), "/cmd_vel", 1.0, 2.0, what="no goal yet")
    assert (caught.value.message, caught.value.at) == (
        "no goal yet: something came on /cmd_vel",
        1.5,
    )


def test_a_period_is_kept_from_begin_to_end() -> None:
    every(timed(*np.arange(0.1, 3.0, 0.1)), "/cmd_vel", 0.1, 0.005)
    for times in ([0.1, 0.2, 0.4], np.arange(0.1, 3.0, 0.05), np.arange(0.1, 2.0, 0.1)):
        with pytest.raises(CheckFailed, match="do not come every 100 ms"):
            every(timed(*times), "/cmd_vel", 0.1, 0.005)


def test_the_log_has_to_say_so_in_time() -> None:
    warned = recording(log=(LogLine(10**9, "warn", "goal is not finite"),))
    logs(warned, ("warn", "error"), what="a goal of NaN", pattern="finite")
    for levels, begin in ((("error",), 0.0), (("warn",), 1.5)):
        with pytest.raises(CheckFailed, match="a goal of NaN: the log does not say so"):
            logs(warned, levels, what="a goal of NaN", begin=begin)
