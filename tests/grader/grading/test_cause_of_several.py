"""Several tasks' checks that fail on one field: what the answers share is said, and no help."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.case import Case, exactly, wrong_unit
from grader.checks.predictions import CALLED, PREDICT
from grader.course.exercises import find_exercise
from grader.exercises.goal_seeking import causes
from grader.exercises.goal_seeking.contract import Pose, Quest
from grader.exercises.latency_monitor import causes as monitor
from grader.grading.causes import several
from grader.grading.causes.answers import seen_in
from grader.grading.causes.find import find_cause
from grader.grading.causes.several import _rows, cause_of_several, in_common, reason_in
from rclpy_virtual_time.link.log import LogLine

EXERCISE = find_exercise("trend_memory")
RIGHT = (0.5, 0.15, 0.0, 0.5, 0.3, -0.2, 0.15, 0.0)
ANSWERS = {  # what is said where so much is right: what is said of it
    lambda right: 0.0: "data is 0.00 in all 8 answers",
    lambda right: None: "data is nothing in all 8 answers",
    lambda right: -right: "has the wrong sign: data is -0.50, not 0.50",
    lambda right: 1000.0 * right: "is 1000 times too big",
    lambda right: right or 0.15: "2 of 8 answers have a wrong data: 2 times 0.15 where 0.00 is",
    lambda right: min(right, 0.1): "5 of 8 answers",
    lambda right: right: "",
}


@pytest.mark.parametrize(("answer", "said"), ANSWERS.items(), ids=list(ANSWERS.values()))
def test_what_wrong_answers_share_is_said(answer: Any, said: str) -> None:
    cases = [
        Case(float(i), "a scan", allowed={"data": exactly(right)}, said=_said(answer(right)))
        for i, right in enumerate(RIGHT)
    ]

    text = in_common(_rows(cases, "data"), "data")

    assert said in text
    assert bool(said) == bool(text)


def test_a_warm_up_is_said_to_be_one() -> None:
    def run(wrong: int, before: float = 0.0) -> Any:
        return _rows([
            Case(float(i), "a scan", allowed={"data": exactly(right)},
                 said={"data": before if i < wrong else right})
            for i, right in enumerate(RIGHT)
        ], "data")  # fmt: skip

    said = several._at_first([run(2), run(2)], "data")
    assert said.startswith("data is 0.00 in the first 2 answers of each run, whatever comes")
    assert not several._at_first([run(2), run(0)], "data")  # not in each
    assert not several._at_first([run(8)], "data")  # nothing follows
    assert not several._at_first([run(2), run(2, 0.1)], "data")


def test_a_sign_that_is_lost_is_seen_in_several_checks() -> None:
    texts = [
        ("linear.x = -0.50 m/s", "linear.x = 0.50 m/s"),
        ("angular.z = -1.90", "angular.z = 1.90"),
    ]
    failed = [_failed("a", 1, *texts[0]), _failed("b", 2, *texts[1]), _failed("c", 2, *texts[1])]

    cause = cause_of_several(EXERCISE, failed, {})

    assert cause is not None
    assert "in 3 checks the number has the right size and the wrong sign" in cause.text.lower()
    assert "abs(…)" in cause.text
    assert (
        cause_of_several(EXERCISE, [*failed, _failed("d", 3, "x = 1.00", "x = 2.00")], {}) is None
    )
    assert cause_of_several(EXERCISE, failed[:2], {}) is None


def test_units_that_are_wrong_are_seen_in_each_answer() -> None:
    cases = [Case(float(i), "", allowed={"ms": exactly(i + 1.0)}, said={"ms": (i + 1) / 1000})
             for i in range(4)]  # fmt: skip

    assert wrong_unit(cases, "ms").startswith("ms is 1,000 times too small in each of 4 answers")
    assert not wrong_unit([*cases, replace(cases[0], said={"ms": 0.002})], "ms")
    assert not wrong_unit(cases[:2], "ms")


@pytest.mark.parametrize("said", [math.inf, -math.inf, math.nan, 1e308, -1e308, 5e-324])
def test_hostile_numbers_have_causes_in_words(said: float, monkeypatch: pytest.MonkeyPatch) -> None:
    told = {"ms": said, "count": said}
    cases = [Case(float(i), "", frozenset({"count", "max_ms"}), {"ms": exactly(right)}, told)
             for i, right in enumerate(RIGHT)]  # fmt: skip
    assert not wrong_unit(cases, "ms")
    assert len(in_common(_rows(cases, "ms"), "ms")) < 300
    assert not several._at_first([_rows(cases, "ms")] * 2, "ms")
    assert not seen_in(cases, "a run")
    falls = [replace(cases[0], said={"count": 1e308}), replace(cases[1], said={}), cases[2]]
    monkeypatch.setattr(monitor, "cases", lambda _: falls)
    run: Any = SimpleNamespace(name="a run", published=[])
    found = monitor.seen({"a run": run}, ["mean_and_max"])
    assert found is None or len(found.text) < 300


def test_a_look_that_stumbles_leaves_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    def stumbles(*_: object) -> None:
        raise OverflowError

    monkeypatch.setattr("grader.grading.causes.find.LOOKS", (stumbles, cause_of_several))
    failed = [_failed(name, 1, "x = -0.50", "x = 0.50") for name in ("a", "b", "c")]
    cause = find_cause(EXERCISE, failed, [])
    assert cause is not None
    assert "wrong sign" in cause.text


def test_the_reason_that_the_node_logs_is_given() -> None:
    case = Case(1.0, "a scan", allowed={"data": exactly(0.3)}, said={"data": 0.0})
    lines = [LogLine(500_000_000, "warn", "too soon"), LogLine(10**9, "info", "here"),
             LogLine(1_020_000_000, "warn", "the scan is\n37 s old")]  # fmt: skip
    reason = reason_in(lines, 1.0)

    text = in_common(_rows([case] * 8, "data"), "data", reason)

    assert "is 0.00 in all 8 answers, and the node's log gives a reason: “the scan is 37 s" in text
    assert reason_in(lines[:2], 1.0) == reason_in(lines, None) == ""


def test_the_check_that_is_named_after_the_field_gives_its_help() -> None:
    failed = [_failed("looks_ahead", 2), _failed("forgets_old", 2), _failed("closing_speed", 3)]

    cause = cause_of_several(EXERCISE, failed, {})

    assert cause is not None
    assert (cause.check, cause.text) == ("closing_speed", "Wrong data on /closing_speed. help 3.")
    assert set(cause.explains) == {check.id for check in failed}


def test_that_check_may_fail_on_another_field() -> None:
    failed = [_failed("looks_ahead", 2), _failed("closing_speed", 3, "count = “1”")]

    cause = cause_of_several(EXERCISE, failed, {})

    assert cause is not None and cause.check == "closing_speed"
    assert cause_of_several(EXERCISE, failed[::-1], {}) is None


def test_checks_of_one_task_keep_their_help(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = Case(1.0, "a scan", allowed={"data": exactly(0.3)}, said={"data": 0.1})
    monkeypatch.setattr(several, "oracle_of", lambda exercise: lambda run: [wrong] * 8)
    runs: Any = {"": None}
    first, same_task = _failed("looks_ahead", 2), _failed("x", 2)
    other_field = _failed("blind", 4, "linear.x = 0.00 m/s")

    assert cause_of_several(EXERCISE, [first, same_task], runs) is None
    assert cause_of_several(EXERCISE, [first, other_field], runs) is None
    another = _failed("x", 3)  # of two, each may have a mistake of its own
    assert cause_of_several(EXERCISE, [first, another], runs) is None
    assert cause_of_several(EXERCISE, [first, same_task, another], runs) is not None


GOALS = [Quest(0.0, 9.0, x, y) for x, y in ((2.0, 1.0), (-2.0, 1.0), (1.0, -2.0), (-1.0, -2.0))]
POSES = [Pose(float(i), i + 1.0, 0.0, 0.0, yaw) for i, yaw in enumerate((0.9, -2.0, 2.8, -2.9))]
TURNS = {  # the turn rate at a goal and a pose: what is said of it
    Quest.heading_error: "",
    causes._bearing: "as if it looked along x",
    lambda goal, pose: -goal.heading_error(pose): "to the wrong side. Bearing minus",
    lambda goal, pose: 1.0: "turns left. Can the angle",
    causes._raw: "",  # the check's help is about wrapping
    lambda goal, pose: causes.math.atan2(goal.x, goal.y) - pose.yaw: "Log both",
}


def test_a_model_that_is_asked_something_else_is_said_to_be() -> None:
    said = {"linear.x": 0.1, PREDICT: f"{CALLED} with other features"}
    case = Case(1.0, "a scan", allowed={"linear.x": exactly(0.3)}, said=said)

    assert "other features than" in in_common(_rows([case] * 8, "linear.x"), "linear.x")


@pytest.mark.parametrize(("turn", "said"), TURNS.items())
def test_what_all_turns_share_is_said(
    monkeypatch: pytest.MonkeyPatch, turn: Any, said: str
) -> None:
    turns = [(goal, pose, turn(goal, pose)) for goal in GOALS for pose in POSES]
    monkeypatch.setattr(causes, "bench_turns", lambda run: turns)
    run: Any = _run(np.zeros((0, 6)))

    found = causes.seen({causes.BENCH: run}, ["turns_short_way"])

    assert said in (found.text if found else "")
    assert bool(said) == bool(found)


@pytest.mark.parametrize(
    ("rate", "more", "same"),
    [(0.4, 0.0, True), (0.4, 1e-9, False), (-1.9, 0.0, False)],  # at its limit it may be right
)
def test_commands_that_never_change_are_said_to_be_so(rate: float, more: float, same: bool) -> None:
    twists = np.tile([0.3, 0.0, 0.0, 0.0, 0.0, rate], (30, 1))
    twists[-1, 5] += more

    found = causes.seen({"goal_far": _run(twists)}, ["warns"])

    assert (found is not None and "the same to the last digit" in found.text) is same


def test_poses_that_the_node_leaves_out_are_no_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(causes, "bad_input", lambda _: {"pose": [1.0], "goal": []})
    run = _run(np.tile([0.3, 0.0, 0.0, 0.0, 0.0, 0.4], (30, 1)))
    run.log = [LogLine(i, "warn", "jumped") for i in range(2)]

    found = causes.seen({"goal_far": run}, ["warns"])

    assert found is not None and "2 times the node says “jumped”, where 1 " in found.text


def _run(twists: Any) -> Any:
    x = np.linspace(0.0, 3.0, 50)
    return SimpleNamespace(
        name="goal_far", log=[], outcome=SimpleNamespace(completed=True),
        twists=lambda: SimpleNamespace(values=twists),
        odometry=lambda: SimpleNamespace(x=x, y=x),
    )  # fmt: skip


def _said(value: float | None) -> dict[str, float]:
    return {} if value is None else {"data": value}


def _failed(name: str, task: int, expected: str = "data = 0.50", actual: str = "none") -> Any:
    message = "wrong data on /closing_speed"
    return SimpleNamespace(
        id=name, task=task, kind="core", message=message, expected=expected, actual=actual,
        help=f"help {task}", where="", scenario=None, hint="", time=None,
    )  # fmt: skip
