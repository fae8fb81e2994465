"""Where a pitfall's node goes wrong: the moments at which its replay opens.

Each function looks at a recording and yields the moments at which a rule is broken. These are not
checks: nothing is graded by them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from grader.checks.ahead import front_distance
from grader.checks.commands import answers, spell
from grader.models.features import possible_features
from grader.models.files import probe
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC, TWIST_STAMPED

AHEAD = 45.0  # [°] to either side, for the nodes that stop at a wall
STOP = 0.8  # [m] closer than this they stop
MAX_SPEED = 0.5  # [m/s] of the nodes with a model
BEAT = 0.4  # [s] longer than eight ticks of its timer a node is silent
SLOW = 0.05  # [m/s] slower than this a robot as good as stands
SILENCE = 10  # scans or commands, and the robot still stands
TURNS_ON = 0.3  # [rad/s] faster than this it is not just correcting its heading

JsonDict = dict[str, Any]


@dataclass(frozen=True)
class Moment:
    """Where a run goes wrong."""

    t: float  # [s]
    rule: str  # the rule that is broken
    expected: str
    actual: str

    def as_dict(self) -> JsonDict:
        """Return what the player shows."""
        return {
            "t": round(self.t, 3), "check": "", "title": self.rule, "outcome": "fail",
            "message": "", "expected": self.expected, "actual": self.actual, "help": "",
        }  # fmt: skip


Moments = Callable[[Recording], Iterator[Moment]]


def does_not_stop(recording: Recording) -> Iterator[Moment]:
    """Drives on although something is less than 0.8 m ahead."""
    for answer in answers(recording):
        distance = front_distance(answer.scan, AHEAD)
        if distance is not None and distance < STOP and answer.speed:
            yield Moment(
                answer.scan.t,
                f"Closer than {STOP} m the robot stands still.",
                f"linear.x = 0.00 m/s: {distance:.2f} m ahead",
                f"linear.x = {spell(answer.speed)} m/s",
            )
            break
    yield from touches(recording)


def mistakes_the_model(off: float, *columns: int) -> Moments:
    """Commands a speed more than `off` [m/s] away from the model's answer to the right features.

    The model gets these columns of exercise 2's features.
    """

    def moments(recording: Recording) -> Iterator[Moment]:
        (model,) = (probe(model) for model in recording.scenario.node.models.values())
        for answer in answers(recording):
            rows = possible_features(answer.scan)[:, list(columns)]
            right = np.clip(model.predict(rows), 0.0, MAX_SPEED)
            said = float("nan") if answer.speed is None else answer.speed
            if not right.min() - off <= said <= right.max() + off:  # so NaN is wrong, too
                yield Moment(
                    answer.scan.t,
                    "The speed is what the model says.",
                    f"linear.x = {(right.min() + right.max()) / 2:.2f} m/s",
                    f"linear.x = {spell(said)} m/s",
                )
                break
        yield from touches(recording)

    return moments


def turns_past_the_goal(recording: Recording) -> Iterator[Moment]:
    """Faces the goal and keeps turning."""
    twists, odometry, goals = recording.twists(), recording.odometry(), recording.goals()
    if not len(goals.t):
        return
    at = np.searchsorted(odometry.t, twists.t, side="right") - 1
    bearing = np.arctan2(goals.y[0] - odometry.y[at], goals.x[0] - odometry.x[at])
    error = np.remainder(bearing - odometry.yaw[at] + np.pi, 2 * np.pi) - np.pi
    past = error * twists.angular_z < 0.0
    wrong = np.flatnonzero(past & (np.abs(twists.angular_z) > TURNS_ON))
    if len(wrong):
        i = int(wrong[0])
        yield Moment(
            float(twists.t[i]),
            "It turns until it faces the goal.",
            f"hardly any turning: the heading error is {error[i]:+.2f} rad",
            f"angular.z = {twists.angular_z[i]:+.2f} rad/s",
        )


def falls_silent(recording: Recording) -> Iterator[Moment]:
    """Does not answer a scan, and the robot keeps executing its last command."""
    truth = recording.truth
    for answer in answers(recording):
        if answer.count:
            continue
        speed = float(np.interp(answer.scan.t, truth.t / 1e9, truth.v))
        yield Moment(
            answer.scan.t,
            "Without a model every scan is answered by a stop.",
            "a Twist with linear.x = 0.00 m/s",
            f"nothing on /cmd_vel; the robot rolls on at {speed:.2f} m/s",
        )
        break
    yield from touches(recording)


def loses_its_beat(recording: Recording) -> Iterator[Moment]:
    """Something is less than 0.8 m ahead, the robot drives, and no command has come for long."""
    commands, truth = recording.twists().t, recording.truth
    for scan in recording.scans():
        distance = front_distance(scan, AHEAD)
        speed = float(np.interp(scan.t, truth.t / 1e9, truth.v))
        before = commands[commands <= scan.t]
        if distance is None or distance >= STOP or speed < SLOW or not len(before):
            continue
        if (silent := scan.t - float(before[-1])) > BEAT:
            yield Moment(
                scan.t,
                "Whatever the model does, commands keep their beat.",
                f"a stop by now: {distance:.2f} m ahead",
                f"no command for {silent:.2f} s; the robot drives on at {speed:.2f} m/s",
            )
            break
    yield from touches(recording)


def speaks_another_type(recording: Recording) -> Iterator[Moment]:
    """Commands come in a type that the robot does not listen to."""
    said = [m for m in recording.of(CMD_VEL_TOPIC) if m.type == TWIST_STAMPED]
    if len(said) >= SILENCE:
        yield Moment(
            said[SILENCE - 1].time / 1e9,
            "The robot does what the node says.",
            "geometry_msgs/msg/Twist on /cmd_vel",
            f"{SILENCE} times geometry_msgs/msg/TwistStamped, and the robot stands",
        )


def hears_nothing(recording: Recording) -> Iterator[Moment]:
    """Scans are sent, and the node receives none."""
    deaf = [end for end in recording.endpoints if end.topic == "/scan" and end.mismatch]
    scans = recording.scans()
    if deaf and len(scans) >= SILENCE and not recording.of(CMD_VEL_TOPIC):
        yield Moment(
            scans[SILENCE - 1].t,
            "Each scan is answered by a Twist.",
            f"{SILENCE} commands by now",
            f"none: {deaf[0].mismatch}",
        )


def touches(recording: Recording) -> Iterator[Moment]:
    """Runs into something."""
    truth = recording.truth
    if truth.contact.any():
        at = truth.t[int(np.argmax(truth.contact))] / 1e9
        yield Moment(float(at), "The robot touches nothing.", "a stop before that", "contact")
