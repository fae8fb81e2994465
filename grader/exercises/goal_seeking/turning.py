"""Whether the robot turns to the side on which its goal is."""

from __future__ import annotations

import math

import numpy as np

from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.goal_seeking.contract import Frame, Pose, Quest, poses
from grader.exercises.goal_seeking.evidence import require_holds
from grader.recording import Recording

EVERY_TURN = (
    "Every turn leads away from the goal: a positive angular.z turns left, and the heading error "
    "is the bearing to the goal minus the robot's yaw."
)


def require_turns(bench: Recording, frame: Frame = Frame.ODOM) -> None:
    """Fail unless each turn rate of a bench leads the short way to the goal."""
    require_alive(bench)
    turns = require_holds(bench, frame)
    away = all(rate * quest.heading_error(pose) < 0 for pose, quest, (_, _, rate) in turns)
    for pose, quest, (time, _, rate) in turns:
        require_sign(bench, quest, pose, time, rate, EVERY_TURN if away else "")


def require_turns_toward(recording: Recording, quest: Quest) -> None:
    """Fail unless the first turn after a goal has the sign of the heading error."""
    twists = recording.twists()
    during = (twists.t >= quest.begin) & (twists.t < quest.end)
    turning = during & (np.abs(twists.angular_z) > 1e-3)
    if not turning.any():
        fail(
            f"the robot never turned on the way to {quest.what}",
            expected="angular.z toward the goal",
            actual="no command that turns",
            at=quest.begin,
            recording=recording,
            help="angular.z = gain · heading error",
        )
    first = int(np.argmax(turning))
    known = [pose for pose in poses(recording) if pose.t <= twists.t[first]]
    if known:
        require_sign(
            recording, quest, known[-1], float(twists.t[first]), float(twists.angular_z[first])
        )


def require_sign(
    recording: Recording, quest: Quest, pose: Pose, time: float, turn_rate: float, help: str = ""
) -> None:
    """Fail if a turn rate [rad/s] leads the long way; near 0 and ±π either way is right."""
    error = quest.heading_error(pose)
    if not 0.2 < abs(error) < math.pi - 0.2:
        return
    if turn_rate * error > 0 and abs(turn_rate) > 1e-3:
        return
    side = "left (positive)" if error > 0 else "right (negative)"
    fail(
        f"the robot does not turn the short way to {quest.what}",
        expected=f"angular.z to the {side}: the heading error is {error:+.2f} rad",
        actual=f"angular.z = {turn_rate:+.2f} rad/s",
        at=time,
        recording=recording,
        help=help
        or "Wrap bearing minus yaw to [-π, π], for example with math.remainder(error, math.tau).",
    )
