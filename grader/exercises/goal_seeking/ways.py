"""The way to a goal: does the robot get there, in step and by a short path, and say so?"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from grader.checks.verbs import every, logs
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.goal_seeking.contract import (
    PERIOD,
    REACTION,
    TOLERANCE,
    Quest,
    bad_input,
    quests,
    seeking,
)
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC

STALE = 0.5  # [s] after which a pose says nothing of where the robot is
LATE = 0.01  # [m] that a robot goes on: the pose it knows is up to an odometry message old
RATE_TOLERANCE = 0.005  # [s] around the period
AT_ONCE = 0.3  # [s] in which the node warns of what it ignores
LOUD = ("warn", "error", "fatal")
NOT_THERE = (
    "The heading error is the bearing to the newest goal minus the robot's yaw; the robot arrives "
    "only within 0.5 m of it. Watch the replay: where does it look, and for which goal?"
)


def sent(recording: Recording) -> list[Quest]:
    """Return the goals that were sent; fail if the program died before the first."""
    found = quests(recording)
    if not found:
        require_alive(recording)
    return found


def reaches(recording: Recording, quest: Quest, within: float = math.inf) -> float:
    """Fail unless the robot drives to a goal in this time [s], before it is carried there.

    Return the ratio of the shortest path to the goal's circle to the path driven.
    """
    require_alive(recording)
    moved = [(each.at, each.teleport) for each in recording.scenario.script if each.teleport]
    carried = [at for at, to in moved if math.dist(to[:2], (quest.x, quest.y)) <= TOLERANCE]
    ends = (quest.end, quest.begin + within, *carried)
    end = min(end for end in ends if end > quest.begin)
    truth, t = recording.truth, recording.truth.t / 1e9
    during = (t >= quest.begin) & (t < end)
    t, x, y = t[during], truth.x[during], truth.y[during]
    distance = np.hypot(x - quest.x, y - quest.y)
    nearest, near = int(np.argmin(distance)), distance <= TOLERANCE + LATE
    if not near.any():
        fail(
            f"the robot did not reach {quest.what}",
            expected=f"within {TOLERANCE} m after at most {end - quest.begin:.0f} s",
            actual=f"{distance[nearest]:.2f} m at the nearest, {distance[-1]:.2f} m at the end",
            at=t[nearest],
            recording=recording,
            help=NOT_THERE,
        )
    there = int(np.argmax(near))
    shortest = float(distance[0] - distance[there])
    driven = np.hypot(np.diff(x), np.diff(y))[:there].sum()
    return shortest / max(shortest, float(driven)) if there else 1.0


def keeps_time(recording: Recording) -> None:
    """Fail unless the commands on the way to a goal, or to another, come every 0.1 s."""
    help = "Publish once in each tick of one 0.1 s timer, on the way to a goal, and nowhere else."
    times = recording.times(CMD_VEL_TOPIC)
    for span in seeking(recording):
        said = times[(times >= span[0]) & (times < span[1])]
        if len(said):
            begin, end = float(said[0]), float(said[-1])
            every(recording, CMD_VEL_TOPIC, PERIOD, RATE_TOLERANCE, begin=begin, end=end, help=help)


def stands_without_odometry(recording: Recording) -> None:
    """Fail unless the robot is stopped when no pose has come for a while, and then goes on."""
    require_alive(recording)
    poses, twists = recording.odometry().t, recording.twists()
    for last, again in pairwise(poses):
        stopped = last + STALE + REACTION
        if again <= stopped:
            continue
        ends = np.append(twists.t[1:], recording.duration_s)
        moves = (twists.values != 0.0).any(axis=1) & (ends > stopped) & (twists.t < again)
        if moves.any():
            fail(
                "the robot drives on though nobody knows where it is",
                expected=f"0.00 m/s, {STALE} s after the last pose",
                actual=f"{twists.linear_x[moves][0]:.2f} m/s; that came at {last:.2f} s",
                at=max(stopped, float(twists.t[moves][0])),
                recording=recording,
                help="Keep the time of each pose, and ask the timer how old the newest is.",
            )
        if not twists.linear_x[(twists.t >= again) & (twists.t < again + REACTION)].any():
            fail(
                "the robot does not drive on when odometry is back",
                expected=f"a command ahead by {REACTION:.2f} s after the first pose",
                at=again + REACTION,
                recording=recording,
                help="What is stale is the pose, not the goal: keep the goal.",
            )


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
