"""The way to a goal: does the robot get there, in step and by a short path, and say so?"""

from __future__ import annotations

import math

import numpy as np

from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import every, logs
from grader.exercises.goal_seeking.contract import (
    PERIOD,
    TOLERANCE,
    Quest,
    bad_input,
    quests,
    seeking,
)
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC

LATE = 0.01  # [m] that a robot goes on: the pose it knows is up to an odometry message old
RATE_TOLERANCE = 0.005  # [s] around the period
AT_ONCE = 0.3  # [s] in which the node warns of what it ignores
LOUD = ("warn", "error", "fatal")
NOT_THERE = (
    "The heading error is the bearing to the newest goal minus the robot's yaw; the robot arrives "
    "only within 0.5 m of it. Watch the replay: where does it look, and for which goal?"
)


def goals_of(recording: Recording) -> list[Quest]:
    """Return the goals of a node that lived to the end."""
    require_alive(recording)
    return quests(recording)


def reaches(recording: Recording, quest: Quest, within: float = math.inf) -> None:
    """Fail unless the robot drives to a goal in this time [s], before it is carried anywhere."""
    truth = recording.truth
    t = truth.t / 1e9
    carried = [event.at for event in recording.scenario.script if event.teleport is not None]
    ends = (quest.end, quest.begin + within, *carried)
    end = min(end for end in ends if end > quest.begin)
    during = np.flatnonzero((t >= quest.begin) & (t < end))
    distance = np.hypot(truth.x - quest.x, truth.y - quest.y)[during]
    if (distance <= TOLERANCE + LATE).any():
        return
    fail(
        f"the robot did not reach {quest.what}",
        expected=f"within {TOLERANCE} m after at most {end - quest.begin:.0f} s",
        actual=f"{distance.min():.2f} m at the nearest, {distance[-1]:.2f} m at the end",
        at=t[during][int(np.argmin(distance))],
        recording=recording,
        help=NOT_THERE,
    )


def keeps_time(recording: Recording) -> None:
    """Fail unless the commands on the way to a goal, or to another, come every 0.1 s."""
    help = "Publish once in each tick of one 0.1 s timer, on the way to a goal, and nowhere else."
    times = recording.times(CMD_VEL_TOPIC)
    for span in seeking(recording):
        said = times[(times >= span[0]) & (times < span[1])]
        if len(said):
            begin, end = float(said[0]), float(said[-1])
            every(recording, CMD_VEL_TOPIC, PERIOD, RATE_TOLERANCE, begin=begin, end=end, help=help)


def announces(recording: Recording, quest: Quest) -> None:
    """Fail unless the log says that a goal is reached, while it is the newest one."""
    logs(
        recording,
        ("info", *LOUD),
        what=f"{quest.what} is reached",
        begin=quest.begin,
        end=quest.end + recording.slack,
        pattern="[Gg]oal [Rr]eached",
        help='self.get_logger().info("Goal reached!"), together with the zero Twist.',
    )


def warns(recording: Recording) -> None:
    """Fail unless the node warned of a goal that is not finite, and of a pose."""
    for what, times in bad_input(recording).items():
        first = min(times, default=recording.duration_s)
        logs(
            recording,
            LOUD,
            what=f"a {what} that is not finite is ignored",
            begin=first,
            end=first + AT_ONCE + recording.slack,
            help="self.get_logger().warning(…): whoever sent it has to hear of it.",
        )


def path_ratio(recording: Recording, quest: Quest) -> float:
    """Return shortest path / path driven to the goal's circle, 0 if it was not reached."""
    truth = recording.truth
    during = (truth.t / 1e9 >= quest.begin) & (truth.t / 1e9 <= quest.end)
    x, y = truth.x[during], truth.y[during]
    distance = np.hypot(x - quest.x, y - quest.y)
    near = np.flatnonzero(distance <= TOLERANCE + LATE)
    if not len(near):
        return 0.0
    steps = np.hypot(np.diff(x), np.diff(y))[: near[0]]
    shortest = float(distance[0] - distance[near[0]])
    return shortest / max(shortest, float(steps.sum()))
