"""Causes that the commands themselves show, and what is no cause: a node that only stands."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.course.exercises import find_exercise
from grader.grading.causes.commands import cause_of_commands, cause_of_standing, never_moves
from grader.grading.plugin import CheckResult
from grader.recording import Outcome
from grader.recording.inferences import Inference

GARBAGE = float(np.frombuffer(b"\x33\x33\xf3\x3e\0\0\0\0", dtype="<f8")[0])  # np.float32(0.475)


@dataclass
class Trial:
    """As much of a recording as is looked at; a command each `step` seconds."""

    commands: list[tuple[float, ...]] = field(default_factory=list)
    step: float = 0.1
    name: str = "trial"
    log: tuple[Any, ...] = ()
    inferences: tuple[Inference, ...] = ()
    outcome: Outcome = field(default_factory=lambda: Outcome("completed"))
    delivered: tuple[str, ...] = ("a scan",)

    def twists(self) -> Any:
        values = np.array(self.commands, dtype=float).reshape(-1, 6)
        speeds = {"linear_x": values[:, 0], "t": self.step * np.arange(len(values))}
        return SimpleNamespace(values=values, **speeds)

    def scans(self) -> tuple[Any, ...]:
        return ()

    def of(self, _: str) -> list[tuple[float, ...]]:
        return self.commands


def failed(id_: str) -> CheckResult:
    return CheckResult(
        id_, "", "core", 0, 10, "fail", "wrong speed", actual="0.0", time=0.01, scenario="trial"
    )


FAILED = [failed("clear_zone"), failed("slow_zone")]
SPEED = (0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
ZERO = (0.0,) * 6


def said(line: str, level: str = "warn") -> Any:
    return SimpleNamespace(text=line, level=level)


def asked(speed: float, method: str = "predict") -> Inference:
    return Inference(method, "model.pkl", 0, 0, 0, (speed,))


@pytest.mark.parametrize(
    ("slug", "trial", "words"),
    [
        ("obstacle_avoidance", Trial(), "publish() in the callback of /scan"),
        ("goal_seeking", Trial(), "its period is in seconds: 0.1"),
        ("ml_velocity", Trial([ZERO, (GARBAGE, *ZERO[1:])]), "At 0.10 s of trial linear.x is"),
        ("goal_seeking", Trial([(0.3, 0.0, 0.0, 1.2, 0.0, 0.0)]), "sets angular.x, and angular.z"),
        ("goal_seeking", Trial([(0.0, 0.3, 0.0, 0.0, 0.0, 1.0)]), "sets linear.y, and linear.x"),
        ("obstacle_avoidance", Trial([(-0.5, *ZERO[1:]), ZERO]), "Forwards is positive"),
        ("goal_seeking", Trial([SPEED] * 4, step=10.0), "every 10 s instead of every 0.1 s"),
        ("safety_supervisor", Trial([SPEED] * 4, step=0.5), "every 0.5 s instead of every 0.05 s"),
    ],
)
def test_what_is_wrong_with_the_commands_is_said(slug: str, trial: Trial, words: str) -> None:
    cause = cause_of_commands(find_exercise(slug), FAILED, {"trial": trial})  # type: ignore[dict-item]
    assert cause is not None
    assert words in cause.text
    assert cause.explains == ("clear_zone", "slow_zone")


@pytest.mark.parametrize(
    ("slug", "trial"),
    [
        ("obstacle_avoidance", Trial([SPEED, ZERO])),
        ("obstacle_avoidance", Trial([ZERO] * 9)),
        ("safety_supervisor", Trial([(-0.5, *ZERO[1:])] * 3, step=0.05)),  # it may drive backwards
        ("slow_model", Trial([SPEED] * 9, step=0.2)),  # waits for its model: no slip of units
        ("model_server", Trial()),  # has no /cmd_vel
        ("ml_velocity", Trial(delivered=())),  # a training script is no node
        ("obstacle_avoidance", Trial(outcome=Outcome("exception"))),
    ],
)
def test_what_may_be_right_is_not_blamed(slug: str, trial: Trial) -> None:
    assert cause_of_commands(find_exercise(slug), FAILED, {"trial": trial}) is None  # type: ignore[dict-item]


@pytest.mark.parametrize(
    ("trial", "words"),
    [
        (Trial([ZERO] * 3, log=(said("A sector without\na reading"),)), "“A sector without a read"),
        (Trial([ZERO] * 3, log=(said("UnicodeDecodeError('utf-8')"),)), "open(path, 'rb')"),
        (Trial([ZERO] * 3, inferences=(asked(0.0, "load"),)), "never asks its model"),
        (
            Trial([ZERO] * 3, log=(said("blind"),), inferences=(asked(0.0, "load"),)),
            "says once: “blind”. It has loaded its model and never",
        ),
        (
            Trial([SPEED] * 3, inferences=tuple(asked(0.1 * i) for i in range(8))),
            "0.50 m/s, and the model says 0.00 to 0.70 m/s",
        ),
        (Trial([ZERO] * 3, log=(said("started", "info"),)), ""),
        (Trial([SPEED] * 3, inferences=(asked(0.5),) * 8), ""),
    ],
)
def test_why_a_node_stands_is_told_only_with_evidence(trial: Trial, words: str) -> None:
    exercise = find_exercise("ml_velocity")
    cause = cause_of_standing(exercise, FAILED, {"trial": trial})  # type: ignore[dict-item]
    assert (cause is not None) == bool(words)
    assert words in (cause.text if cause else "")


def test_a_speed_that_is_no_number_is_one_that_moves() -> None:
    assert never_moves({"trial": Trial([ZERO] * 3)})  # type: ignore[dict-item]
    assert not never_moves({"trial": Trial([(float("nan"), *ZERO[1:])])})  # type: ignore[dict-item]
