"""Which command answers which scan, and what the fields of a Twist hold."""

import math

import msgspec
import numpy as np
import pytest
from node_runs import RunNode, short

from grader.checks.commands import (
    answers,
    garbage,
    is_zero,
    spell,
)
from grader.checks.verdict import CheckFailed
from grader.checks.words import answers_once

NODE = """
class Agent(Echo):
    def __init__(self):
        super().__init__()
        {start}
    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = 0.25
        {each}
rclpy.init()
rclpy.spin(Agent())
"""
PUBLISH = "self.publisher.publish(twist)"


def node(each: str = PUBLISH, start: str = "pass") -> str:
    return NODE.format(each=each, start=start)


WATCHDOG = """self.create_timer(0.1, self.watch)
        self.heard = None
    def watch(self):
        late = self.heard and self.get_clock().now().nanoseconds - self.heard > 5e8
        if late:
            twist = Twist()
            twist.linear.x = {speed}
            self.publisher.publish(twist)
            self.heard = None"""
HEARS = PUBLISH + "; self.heard = self.get_clock().now().nanoseconds"


@pytest.mark.parametrize(("speed", "counts"), [(0.0, {1}), (0.1, {1, 2})])
def test_a_watchdog_may_stop_the_robot_and_no_more(
    run_node: RunNode, speed: float, counts: set[int]
) -> None:
    scenario = short(3.0)
    faults = msgspec.structs.replace(scenario.faults, blackout=((1.0, 2.0),))
    recording = run_node(
        node(HEARS, WATCHDOG.format(speed=speed)), msgspec.structs.replace(scenario, faults=faults)
    )

    assert {answer.count for answer in answers(recording)} == counts
    assert {answer.speed for answer in answers(recording)} == {0.25} | ({speed} - {0.0})
    said = answers(recording)[0].said("linear.x", "angular.z")
    assert said == {"linear.x": 0.25, "angular.z": 0.0}


@pytest.mark.parametrize(
    ("each", "start", "message"),
    [
        (f"{PUBLISH}; {PUBLISH}", "pass", "2 commands followed"),
        (PUBLISH, "self.publisher.publish(Twist())", "a command came before the first scan"),
    ],
)
def test_anything_but_one_command_each_fails(
    run_node: RunNode, each: str, start: str, message: str
) -> None:
    recording = run_node(node(each, start), short(1.0))
    with pytest.raises(CheckFailed, match=message):
        answers_once([recording])


def test_nan_is_not_zero() -> None:
    numbers = np.array([0.0, -0.0, 1e-7, 1e-5, math.nan, math.inf])
    assert is_zero(numbers).tolist() == [True, True, True, False, False, False]


@pytest.mark.parametrize(
    ("value", "text", "is_garbage"),
    [
        (0.5, "0.50", False),
        (0.00123, "0.00123", False),
        (math.inf, "inf", False),
        (5e-324, "", True),
        (1e300, "", True),
        (math.nan, "nan", True),
    ],
)
def test_numbers_are_spelt_and_what_only_a_wrong_type_makes_is_garbage(
    value: float, text: str, is_garbage: bool
) -> None:
    assert bool(garbage(value)) is is_garbage
    assert not text or spell(value) == text
