"""What a node publishes: which command answers which scan, its fields, what can't be read."""

import math
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
from node_runs import RunNode, short

from grader.checks.commands import answered_in_turn, answers, garbage, published, spell
from grader.checks.verbs import answers_once
from grader.checks.verdict import CheckFailed
from sim.messages import FLOAT64, Message, encode, typestore

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
EARLY = """def early():
            self.publisher.publish(Twist())
            self.timer.cancel()
        self.timer = self.create_timer(0.002, early)"""


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
        (PUBLISH, EARLY, "a command came before the first scan"),
    ],
)
def test_anything_but_one_command_each_fails(
    run_node: RunNode, each: str, start: str, message: str
) -> None:
    recording = run_node(node(each, start), short(1.0))
    with pytest.raises(CheckFailed, match=message):
        answers_once([recording])


@pytest.mark.parametrize(
    ("value", "text", "is_garbage"),
    [
        (0.5, "0.50", False),
        (0.00123, "0.00123", False),
        (1700000000.0134, "1700000000.013", False),
        (math.inf, "inf", False),
        (-1e300, "-1e+300", True),
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


# --- answers in turn, in real time

SCANS = np.arange(20) / 10  # [s]
END = 2.0  # [s]


def recording(commands: Any, live: object = "live", queued: float = 0.0) -> Any:
    return SimpleNamespace(
        live=live,
        compute=SimpleNamespace(time=SCANS, queued=np.full(len(SCANS), queued)),  # in each turn
        duration_s=END,
        times=lambda topic: SCANS,
        twists=lambda: SimpleNamespace(t=np.asarray(commands, float)),
    )


@pytest.mark.parametrize(
    ("commands", "count"),
    [
        (SCANS + 0.01, 20),
        (SCANS + 0.15, 20),  # each when the next scan is there already
        (SCANS[:18] + 0.15, 18),  # the last two answers come after the end
        (SCANS[:16] + 0.15, 0),  # four scans were never answered
        (SCANS - 0.01, 0),  # before its scan
        (SCANS + 0.7, 0),  # seven scans late is no answer
        (np.append(SCANS + 0.01, 1.99), 0),  # one too many
        ([], 0),
    ],
)
def test_answers_count_in_turn_if_they_come_in_time(commands: Any, count: int) -> None:
    assert answered_in_turn(recording(commands)) == count


def test_a_node_that_had_to_wait_for_a_cpu_may_answer_later() -> None:
    late = SCANS[:13] + 0.7  # seven turns later
    scans = SCANS[:13]
    for queued, count in ((0.0, 0), (0.02, 0), (0.04, 13)):
        short = recording(late, queued=queued)
        short.times = lambda topic: scans
        assert answered_in_turn(short) == count


def test_in_virtual_time_nothing_is_late() -> None:
    assert answered_in_turn(recording(SCANS + 0.01, live=None)) == 0


# --- bytes that are no message

TOPIC = "/closing_speed"


def message(data: bytes) -> Message:
    return Message(TOPIC, FLOAT64, 1_500_000_000, data)


def said(value: float) -> bytes:
    return encode(typestore().types[FLOAT64](data=value), FLOAT64)


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", said(0.5)[:-1]])
def test_what_cannot_be_read_fails(data: bytes) -> None:
    recording = SimpleNamespace(published=(message(data),), name="run")
    with pytest.raises(CheckFailed, match="a message on /closing_speed can't be read") as caught:
        published(recording, TOPIC, FLOAT64)
    assert caught.value.at == 1.5


def test_of_a_flood_only_so_much_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grader.checks.commands.MOST_SAID", 3 * len(said(0.5)))
    recording = SimpleNamespace(published=(message(said(0.5)),) * 3, name="run")
    assert len(published(recording, TOPIC, FLOAT64)) == 3
    recording.published *= 2
    with pytest.raises(CheckFailed) as caught:
        published(recording, TOPIC, FLOAT64)
    assert "so far these are 48 bytes; 36 are read" in caught.value.actual
