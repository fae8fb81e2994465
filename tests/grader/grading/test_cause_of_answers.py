"""What all answers of a node have in common is seen in a recording, and nothing else."""

from dataclasses import replace
from pathlib import Path

import pytest
from node_runs import RunNode

from grader.checks.case import Case, exactly
from grader.course.exercises import SOLUTIONS, find_exercise
from grader.exercises import oracle_of
from grader.grading.causes.answers import cause_of_answers, publishers_of, seen_in
from grader.grading.plugin import CheckResult
from grader.recording import Recording
from sim.scenario_files import load_scenario

EXERCISE = find_exercise("obstacle_avoidance")
ZONES = "avoid_zones"
NODE = """
import math
from collections import deque
from statistics import median
class Agent(Echo):
    def __init__(self):
        super().__init__('agent')
        self.last, self.kept, self.stopped = None, deque(maxlen=5), False
    def speed_of(self, scan):
        near = []
        for i, reading in enumerate(scan.ranges):
            angle = math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)
            if abs(angle) <= math.pi / 2:
                if reading == -math.inf:
                    near.append(0.0)
                elif reading == math.inf or scan.range_min <= reading <= scan.range_max:
                    near.append(reading)
        d = min(near, default=0.0)
        return 0.0 if d < 0.5 else 0.15 if d < 1.0 else 0.5
    def on_scan(self, scan):
        speed = self.speed_of(scan)
        BODY
    def send(self, speed):
        twist = Twist()
        twist.linear.x = float(speed)
        self.publisher.publish(twist)
rclpy.init()
rclpy.spin(Agent())
"""
MISTAKES = {
    "self.send(speed if self.last is None else self.last); self.last = speed": "scan before it",
    "self.kept.append(speed); self.send(self.kept[0])": "the scan 4 before it",
    "self.send(speed) if speed != self.last else None; self.last = speed": "nothing is published",
    "self.kept.append(speed); self.send(median(self.kept))": "also the median of what the last 5",
    "self.last = speed if self.last is None else self.last + 0.3 * (speed - self.last); "
    "self.send(self.last)": "goes 30 % of the way",
    "self.publisher = self.create_publisher(Twist, '/cmd_vel', 10); self.send(speed)": (
        "Is one made with each message?"
    ),
    "self.send(speed)": "",
    "self.send(speed if speed != 0.15 else 0.2)": "",  # wrong in another way
    "self.send(0.5 - speed)": "",
}


@pytest.mark.parametrize(("body", "said"), MISTAKES.items(), ids=[*map(str, range(len(MISTAKES)))])
def test_a_stateful_slip_is_seen_in_the_answers(run_node: RunNode, body: str, said: str) -> None:
    recording = run_node(NODE.replace("BODY", body), load_scenario(ZONES))
    text = _seen(recording)
    assert said in text if said else not text


def test_where_only_the_field_fails_the_answers_are_not_blamed(run_node: RunNode) -> None:
    late = next(iter(MISTAKES))
    recording = run_node(NODE.replace("BODY", late), load_scenario(ZONES))
    for kind in ("core", "field"):
        failed = CheckResult("a", "A.", kind, 0, 0, "fail", scenario=ZONES)
        cause = cause_of_answers(EXERCISE, [failed], {ZONES: recording})
        assert (cause is not None) == (kind == "core")


def _seen(recording: Recording) -> str:
    return publishers_of(recording) or seen_in(oracle_of(EXERCISE)(recording), ZONES)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ([0.0] * 7 + [1.0], "without its decimals"),
        ([0.0] * 8, ""),  # whatever the reason
        ([0.1, 0.2, 0.3, 0.4, 0.4, 0.4, 0.4, 0.4], "never change back"),
        ([0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0], "never change back"),
        ([0.1, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5], "change by 0.05 at most"),
        ([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 1.5], ""),
        ([0.3, 0.1, 0.7, 0.2, 0.9, 0.1, 0.1, 0.2], ""),
    ],
)
def test_the_rest_is_seen_in_cases(said: list[float], words: str) -> None:
    right = [0.1, 0.2, 0.3, min(0.4, said[3] * 9), 0.5, 0.6, 0.7, 1.5]
    cases = [
        Case(i / 10, "a scan", allowed={"linear.x": exactly(r)}, said={"linear.x": s})
        for i, (r, s) in enumerate(zip(right, said, strict=True))
    ]
    text = seen_in(cases, "x")
    if "never" in words and not said[-1]:
        assert not seen_in(cases, "x", period=True)  # a timer's, once all is too old
    assert words in text if words else not text
    cases[1] = replace(cases[1], allowed={"linear.x": ((0.9, 1.0),)})  # no one number is right
    assert "nan" not in seen_in(cases, "x")


@pytest.mark.parametrize(
    "file", sorted((SOLUTIONS / "obstacle_avoidance").rglob("*.py")), ids=lambda file: file.stem
)
def test_right_nodes_read_nothing(run_node: RunNode, file: Path) -> None:
    assert not _seen(run_node(file.read_text("utf-8"), load_scenario(ZONES)))
