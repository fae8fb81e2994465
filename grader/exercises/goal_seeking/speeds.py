"""Whether the robot is as fast as its distance to the goal allows."""

from __future__ import annotations

import numpy as np

from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.goal_seeking.contract import Frame, poses, quests, speed_law
from grader.exercises.goal_seeking.evidence import garbage, quest_at, require_holds
from grader.recording import Recording

LAW_TOLERANCE = 0.005  # [m/s]
STRAIGHT = 0.01  # [rad] from the goal


def require_speeds(bench: Recording, frame: Frame, until: float) -> None:
    """Fail unless each speed of a bench is the law's; it may be less where the robot turns.

    What comes later than `until` [s] is not judged.
    """
    require_alive(bench)
    for pose, quest, (time, speed, _) in require_holds(bench, frame, until):
        older = [q.distance(pose) for q in quests(bench, frame) if q.begin < quest.begin]
        straight = abs(quest.heading_error(pose)) < STRAIGHT
        _require_law(bench, time, speed, quest.distance(pose), older if straight else None)


def require_no_faster(drive: Recording, frame: Frame) -> None:
    """Fail if a speed on a drive is greater than the law's."""
    require_alive(drive)
    known, twists = poses(drive), drive.twists()
    heard = np.array([pose.t for pose in known])
    for time, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        goal, last = quest_at(drive, time, frame), int(np.searchsorted(heard, time, side="right"))
        if goal is not None and last:
            distance = max(goal.distance(pose) for pose in known[max(0, last - 2) : last])
            _require_law(drive, time, speed, distance)


def _require_law(
    recording: Recording,
    time: float,
    speed: float,
    distance: float,
    older: list[float] | None = None,
) -> None:
    """Fail if a speed [m/s] is too fast, or (with distances to `older` goals [m]) too slow."""
    wanted = speed_law(distance)
    too_slow = older is not None and speed < wanted - LAW_TOLERANCE
    within = speed <= wanted + LAW_TOLERANCE  # never true of NaN
    if too_slow or not within:
        fail(
            f"wrong speed at {distance:.2f} m from the goal",
            expected=f"linear.x = min(0.3, 0.5 · {distance:.2f}) = {wanted:.3f} m/s",
            actual=f"linear.x = {speed:.3f} m/s",
            at=time,
            recording=recording,
            help=garbage(speed) or _of_older(speed, older or []) or "min(0.3, 0.5 * distance)",
        )


def _of_older(speed: float, distances: list[float]) -> str:
    """Say so if a speed [m/s] fits the distance to one of the older goals [m]."""
    fits = any(abs(speed_law(old) - speed) <= LAW_TOLERANCE for old in distances)
    if not fits:
        return ""
    return "That is the speed for an older goal: does a new one replace it, whenever it comes?"
