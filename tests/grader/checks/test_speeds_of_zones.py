"""Exercise 1: a node's own speeds count where its perception is asked, and its zones are not."""

from typing import Any

import numpy as np
import pytest

from grader.checks.commands import Answer
from grader.checks.verdict import CheckFailed
from grader.exercises.obstacle_avoidance import evidence
from grader.exercises.obstacle_avoidance.evidence import CONTRACT, own_speeds, require_speed
from grader.recording import Scan

NOTHING: Any = None


def wall(distance: float) -> Scan:
    return Scan(
        t=1.0,
        stamp=1.0,
        ranges=np.full(360, distance),
        angle_min=-np.pi,
        angle_increment=2 * np.pi / 360,
        range_min=0.15,
        range_max=12.0,
    )


def answer(tag: str, speed: float, distance: float = 5.0) -> Answer:
    return Answer(scan=wall(distance), label=tag, tags=(tag,), count=1, speed=speed)


@pytest.mark.parametrize(
    ("stop", "slow", "clear", "own"),
    [
        ((0.0,), (0.15,), (0.5,), CONTRACT),
        ((0.0,), (0.15,), (1.0,), {0.0: (0.0, 0.0), 0.15: (0.15, 0.15), 0.5: (1.0, 1.0)}),
        ((0.0,), (0.3,), (0.5,), {0.0: (0.0, 0.0), 0.15: (0.3, 0.3), 0.5: (0.5, 0.5)}),
        ((0.0,), (0.2, 0.4), (0.5,), CONTRACT | {0.15: (0.2, 0.4)}),  # a ramp
        ((-0.1, 0.0), (0.15,), (0.5,), CONTRACT | {0.0: (-0.1, 0.0)}),  # backs up
        ((0.0,), (0.2, 0.5), (0.5,), CONTRACT),  # the zones can't be told apart
        ((0.0,), (0.15,), (0.5, 1.0), CONTRACT),  # not one speed
        ((0.1,), (0.15,), (0.5,), CONTRACT),  # does not stand
        ((0.0,), (0.5,), (0.5,), CONTRACT),  # not slower when nearer
        ((0.0,), (0.15,), (float("nan"),), CONTRACT),
        ((0.0,), (0.15,), (), CONTRACT),  # never said
    ],
)
def test_own_speeds_rise_from_a_stop(
    monkeypatch: pytest.MonkeyPatch,
    stop: tuple[float, ...],
    slow: tuple[float, ...],
    clear: tuple[float, ...],
    own: dict[float, tuple[float, float]],
) -> None:
    said = {"stop": stop, "slow": slow, "clear": clear}
    found = [answer(tag, speed) for tag, speeds in said.items() for speed in speeds]
    monkeypatch.setattr(evidence, "require_alive", lambda _: None)
    monkeypatch.setattr(evidence, "answers", lambda _: found)

    assert own_speeds(NOTHING) == own


def test_an_own_speed_is_right_and_the_message_says_the_contracts() -> None:
    own = CONTRACT | {0.5: (1.0, 1.0)}
    require_speed(NOTHING, answer("behind", 1.0), own=own)

    with pytest.raises(CheckFailed) as failed:
        require_speed(NOTHING, answer("behind", 0.0), own=own)

    assert failed.value.expected.startswith("linear.x = 0.50 m/s (1.00 would do here")


@pytest.mark.parametrize(
    ("speed", "count", "actual"),
    [
        (0.149, 1, "linear.x = 0.149 m/s"),  # not the digits of what is expected
        (0.5, 0, "no Twist for this scan; the robot goes on at 0.50 m/s"),
    ],
)
def test_the_message_says_what_came(speed: float, count: int, actual: str) -> None:
    slow = Answer(scan=wall(0.75), label="slow", tags=("slow",), count=count, speed=speed)

    with pytest.raises(CheckFailed) as failed:
        require_speed(NOTHING, slow)

    assert failed.value.actual == actual
