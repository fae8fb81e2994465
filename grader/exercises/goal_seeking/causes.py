"""What the turns of a node have in common, for exercise 3: seen in the poses of a bench."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from grader.checks.verdict import Evidence, Trials
from grader.exercises.goal_seeking.contract import (
    CONTRACT,
    TURNS,
    UNSURE,
    Pose,
    Quest,
    bad_input,
    bench_turns,
)
from grader.recording import Recording

BENCH = "goal_turns"
LEAST = 6  # turns
MANY, FAR = 20, 0.5  # commands, and [m] driven with them
EXPLAINS = ("turns_short_way", "reaches_goal", "reaches_any_goal", "new_goal", "path_efficiency")


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that the commands never change, or what the robot's turns have in common."""
    if text := next(filter(None, map(_frozen, trials.values())), ""):
        return Evidence(text, explains=failed)
    run = trials.get(BENCH)
    if run is None or not run.outcome.completed or "turns_short_way" not in failed:
        return None
    turns = [each for each in bench_turns(run) if abs(each[2]) > TURNS]
    plain = [each for each in turns if abs(_raw(*each[:2])) < math.pi]
    wrong = [(q, p, rate) for q, p, rate in plain if rate * _raw(q, p) < 0.0]
    if len(turns) < LEAST or not wrong:
        return None
    text = _in_common(turns)
    if not text:
        quest, pose, _ = wrong[0]
        text = (
            f"the robot turns to the wrong side where nothing has to be wrapped, too: at "
            f"{pose.t:.2f} s of {BENCH} the bearing is {_bearing(quest, pose):.2f} rad and the yaw "
            f"{pose.yaw:.2f} rad. Log both: are they the same in your node?"
        )
    return Evidence(text, hint="3.1", explains=EXPLAINS)


def _frozen(run: Recording) -> str:
    """Say that all commands are the same, though the robot's pose is another at each."""
    twists, odom = run.twists().values, run.odometry()
    same = len(twists) >= MANY and np.ptp(twists, axis=0).max() == 0.0 and twists.any()
    if (
        not same
        or abs(twists[0, 5]) >= CONTRACT.limits.turning
        or not run.outcome.completed
        or np.ptp(odom.x) + np.ptp(odom.y) < FAR
    ):
        return ""
    same_to = (
        f"all {len(twists)} commands of {run.name} are the same to the last digit, though each "
        "message on /odom had another pose"
    )
    warned = Counter(line.text for line in run.log if line.level == "warn").most_common(1)
    if warned and warned[0][1] > (bad := sum(map(len, bad_input(run).values()))):
        return (
            f"{same_to}, and {warned[0][1]} times the node says “{warned[0][0][:80]}”, where {bad} "
            "messages were not finite. Does a condition leave good poses out?"
        )
    return (
        f"{same_to}. Does a loop or a sleep in one callback keep the others "
        "from being called? Return, and let the timer call again; or is the pose kept nowhere?"
    )


def _in_common(turns: Sequence[tuple[Quest, Pose, float]]) -> str:
    """Return what explains all turns, in a sentence; "" if nothing does."""
    rates = [rate for _, _, rate in turns]
    every = f"in all {len(turns)} poses of {BENCH} the robot turns"
    if min(rates) > 0.0 or max(rates) < 0.0:
        side = "left" if rates[0] > 0.0 else "right"
        return f"{every} {side}. Can the angle between bearing and yaw have both signs?"
    if all(rate * quest.heading_error(pose) < 0.0 for quest, pose, rate in turns):
        return (
            f"{every} to the wrong side. Bearing minus yaw is positive to the left, as angular.z."
        )
    unsure = (abs(math.sin(_bearing(quest, pose))) < UNSURE for quest, pose, _ in turns)
    ahead = (rate * _bearing(quest, pose) > 0.0 for quest, pose, rate in turns)
    if all(either or right for either, right in zip(unsure, ahead, strict=True)):
        return (
            f"{every} as if it looked along x, whatever its yaw. Log the yaw: is it always 0, or "
            "is it not subtracted from the bearing?"
        )
    return ""


def _bearing(quest: Quest, pose: Pose) -> float:
    return math.atan2(quest.y - pose.y, quest.x - pose.x)


def _raw(quest: Quest, pose: Pose) -> float:
    return _bearing(quest, pose) - pose.yaw
