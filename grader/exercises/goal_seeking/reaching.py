"""Whether the robot finds its goals: the verdicts on its way, and where that ends."""

from __future__ import annotations

import math

import numpy as np

from grader.checks.verdict import fail
from grader.exercises.goal_seeking.contract import (
    TOLERANCE,
    Pose,
    Quest,
    arrival,
    quests,
)
from grader.exercises.goal_seeking.evidence import REACTION, stop_times, zero_commands
from grader.recording import Recording

FACING = 0.3  # [rad] from the goal
STILL = 20  # samples of the robot's pose
STOPS_SHORT = (
    "It looks at the goal and stands: is the distance math.hypot(dx, dy), and does it arrive only "
    "within 0.5 m?"
)
FACES_AND_DRIVES = (
    "It turns until it faces the goal, and keeps driving: the heading error is the bearing to the "
    "goal minus the robot's yaw. Watch the replay."
)


def carried_at(recording: Recording, quest: Quest) -> float:
    """Return when somebody carries the robot while a goal counts [s]; its end if nobody does."""
    times = [event.at for event in recording.scenario.script if event.teleport is not None]
    return min((time for time in times if quest.begin < time < quest.end), default=quest.end)


def reached(
    recording: Recording,
    quest: Quest,
    within: float = math.inf,
    tolerance: float = TOLERANCE,
) -> bool:
    """Tell whether the real robot drove to within the tolerance [m] of a goal."""
    _, distance = _way_there(recording, quest, within)
    # The robot stops a little late: its pose is up to an odometry message and a tick old.
    return bool((distance <= tolerance + 0.01).any())


def _way_there(recording: Recording, quest: Quest, within: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the (n,) indices of the real poses on the way, and how far the goal was [m]."""
    truth = recording.truth
    t = truth.t / 1e9
    during = np.flatnonzero((t >= quest.begin) & (t < _deadline(recording, quest, within)))
    return during, np.hypot(truth.x - quest.x, truth.y - quest.y)[during]


def _deadline(recording: Recording, quest: Quest, within: float) -> float:
    return min(carried_at(recording, quest), quest.begin + within)


def require_reached(
    recording: Recording,
    quest: Quest,
    within: float = math.inf,
    tolerance: float = TOLERANCE,
) -> None:
    """Fail unless the real robot drove to within the tolerance [m] of a goal."""
    during, distance = _way_there(recording, quest, within)
    if not len(during):
        fail(f"the scenario ended before {quest.what}", recording=recording)
    if not reached(recording, quest, within, tolerance):
        truth, last = recording.truth, during[-1]
        t = truth.t / 1e9
        end = _deadline(recording, quest, within)
        off = quest.heading_error(Pose(*(float(a[last]) for a in (t, truth.x, truth.y, truth.yaw))))
        facing, still = abs(off) < FACING, float(np.ptp(distance[-STILL:])) < 1e-3
        fail(
            f"the robot did not reach {quest.what}",
            expected=f"within {TOLERANCE} m after at most {end - quest.begin:.0f} s",
            actual=f"{distance.min():.2f} m at the nearest, {distance[-1]:.2f} m at the end, where "
            f"it looks {abs(off):.1f} rad away from the goal",
            at=float(t[during][int(np.argmin(distance))]),
            recording=recording,
            help=_older_goal(recording, quest, truth.x[last], truth.y[last])
            or (STOPS_SHORT if facing and still else FACES_AND_DRIVES),
        )


def _older_goal(recording: Recording, quest: Quest, x: float, y: float) -> str:
    """Say so if the robot ended at an older goal."""
    for old in quests(recording):
        if old.begin < quest.begin and math.hypot(old.x - x, old.y - y) <= TOLERANCE + 0.1:
            return f"It drove to {old.what}, an older one: a new goal replaces it at any time."
    return ""


def require_heard(recording: Recording, quest: Quest) -> None:
    """Fail unless the robot sets out for a goal at once, and stops there when it is carried there.

    That a goal is heard shows, too, in a node that finds the way to none.
    """
    twists, zero = recording.twists(), zero_commands(recording)
    moving = twists.t[~zero & (twists.t >= quest.begin) & (twists.t < quest.end)]
    if not len(moving) or moving[0] > quest.begin + REACTION:
        fail(
            f"the robot does not set out for {quest.what}",
            expected=f"a command that moves it by {quest.begin + REACTION:.2f} s",
            actual=f"the first one at {moving[0]:.2f} s" if len(moving) else "none",
            at=quest.begin,
            recording=recording,
            help="A new goal replaces the old one, whether that is reached or not.",
        )
    there = arrival(recording, quest)
    stops = stop_times(recording, quest)
    if there is None or not len(stops) or stops[0] > there + REACTION:
        fail(
            f"the robot was at {quest.what}, and did not stop",
            expected="a zero Twist at the next tick",
            actual=f"one at {stops[0]:.2f} s" if len(stops) else "none",
            at=carried_at(recording, quest) if there is None else there,
            recording=recording,
            help="A new goal replaces the old one: compare your pose with the newest.",
        )


def require_on_the_way(recording: Recording, quest: Quest) -> None:
    """Fail unless the robot reaches a goal, or looks at it at the end.

    That is for who takes goals for other places: there may not be the time to get there.
    """
    during, distance = _way_there(recording, quest, math.inf)
    if not len(during) or reached(recording, quest):
        return
    truth, last = recording.truth, during[-1]
    t = float(truth.t[last] / 1e9)
    at = Pose(t, *(float(numbers[last]) for numbers in (truth.x, truth.y, truth.yaw)))
    off = abs(quest.heading_error(at))
    if off < FACING and distance[-1] < distance[0]:
        return
    fail(
        f"the robot is not on the way to {quest.what}",
        expected=f"arrival by {t:.1f} s, or at least the right direction",
        actual=f"{distance[-1]:.2f} m away, where it looks {off:.1f} rad away from it",
        at=t,
        recording=recording,
        help="A new goal replaces the old one, whether that is reached or not.",
    )


def path_ratio(recording: Recording, tolerance: float) -> float:
    """Return shortest path / path driven to the goal's circle, 0 if it was not reached."""
    quest, truth = quests(recording)[0], recording.truth
    t = truth.t / 1e9
    during = (t >= quest.begin) & (t <= quest.end)
    x, y = truth.x[during], truth.y[during]
    distance = np.hypot(x - quest.x, y - quest.y)
    near = np.flatnonzero(distance <= tolerance + 0.01)
    if not len(near):
        return 0.0
    steps = np.hypot(np.diff(x), np.diff(y))[: near[0]]
    shortest = float(distance[0] - distance[near[0]])
    return shortest / max(shortest, float(steps.sum()))
