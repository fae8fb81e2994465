"""What a node makes of its goals, right or wrong: a mistake is named, and paid for, once.

Each habit has a check that fails for it; the other checks take it as given.
"""

from __future__ import annotations

import math

from grader.checks.verdict import CheckFailed, passes
from grader.exercises.goal_seeking.contract import (
    HAIR,
    MAX_SPEED,
    PERIOD,
    TOLERANCE,
    Frame,
    arrival,
    poses,
    quests,
)
from grader.exercises.goal_seeking.evidence import (
    command_times,
    garbage,
    require_holds,
    require_one_stop,
    stop_times,
)
from grader.exercises.goal_seeking.turning import require_turns
from grader.recording import Recording

TURNS = "goal_turns"  # shows what it takes a goal for, and what it writes into angular.z
ARRIVAL = "goal_arrival"  # shows how near is near enough for it
NEAR = "goal_near"  # shows whether it hears of a goal once it has arrived
FARTHEST = 2 * TOLERANCE  # [m] from its goal that anybody arrives
TICK = MAX_SPEED * PERIOD + 0.02  # [m] from one tick to the next, and an odometry message


def frame_of(turns: Recording) -> Frame:
    """Return what a node takes goals for; if it is wrong, `turns_short_way` fails.

    All its turns have to lead there.
    """
    found = (frame for frame in Frame if passes(require_turns, turns, frame))
    return next(found, Frame.ODOM)


def turns_in_garbage(turns: Recording) -> bool:
    """Tell whether angular.z is not read as it was meant; `turns_short_way` fails then."""
    if passes(require_turns, turns):
        return False
    try:
        said = require_holds(turns)
    except CheckFailed:
        return False
    return all(garbage(rate) for _, _, (_, _, rate) in said)


def tolerance_of(push: Recording) -> float:
    """Return how far from its goal a node arrives [m]; if too far, `stops_once` fails."""
    if not (told := quests(push)):  # a node that died before the first goal
        return TOLERANCE
    quest = told[-1]
    stops = stop_times(push, quest)
    known = [pose for pose in poses(push) if len(stops) and pose.t <= stops[0]]
    nearest = quest.distance(known[-1]) if known else 0.0
    far = TOLERANCE + HAIR < nearest <= FARTHEST
    return nearest + TICK if far and not passes(require_one_stop, push, quest) else TOLERANCE


def deaf_from(near: Recording, bench: Recording) -> float:
    """Return when in a bench a node hears of no goal any more [s], inf: it always does.

    If it does not, `near_goal` fails.
    """
    later = quests(near)[1:]
    if not later or any(len(command_times(near, quest.begin, quest.end)) for quest in later):
        return math.inf
    arrivals = [arrival(bench, quest) for quest in quests(bench)]
    return min((time for time in arrivals if time is not None), default=math.inf)
