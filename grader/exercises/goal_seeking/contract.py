"""The oracle of goal_seeking: what its contract asks for, from recorded poses and goals."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter, itemgetter

import numpy as np

from grader.checks.case import Case, exactly
from grader.checks.commands import ZERO
from grader.checks.contract import Contract, Limits
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC as CMD_VEL

TOLERANCE = 0.5  # [m] within this distance a goal is reached
MAX_SPEED = 0.3  # [m/s]
MAX_TURN_RATE = 1.9  # [rad/s]
SPEED_GAIN = 0.5  # [1/s]
PERIOD = 0.1  # [s] of the control loop
MARGIN = 0.001  # [m] distances this near to the tolerance may fall on either side
REACTION = 2.5 * PERIOD  # [s] long enough for a tick of the control loop, even at 5 Hz
UNHEARD = 0.05  # [s] a command that comes so soon after a goal need not be about it
STANDS = 0.3  # [s] for which a bad message is the newest one
STRAIGHT = 0.01  # [rad] from the goal: the robot has no reason to turn
UNSURE = 0.2  # [rad] from ahead and from behind, where a turn to either side is right
TURNS = 1e-3  # [rad/s]
STEADY = 0.1  # [rad/s] either way of a robot that looks straight at its goal

CONTRACT = Contract(
    limits=Limits(fastest=MAX_SPEED, turning=MAX_TURN_RATE),
    period=PERIOD,
    goals=True,
    race=("goal_origin_to_5_3", "goal_behind", "goal_across_the_seam"),
)
COMMANDS = {CMD_VEL: frozenset({"commands"})}  # whatever they say
STILL = {"linear.x": 0.0, "angular.z": 0.0}  # [m/s] and [rad/s]
Rows = list[list[float]]
Said = Mapping[str, float]  # a command's numbers, by the names of STILL; none: no command


@dataclass(frozen=True)
class Pose:
    """A pose, and for how long it was the newest one that the node was sent."""

    t: float  # [s]
    end: float  # [s]
    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]


@dataclass(frozen=True)
class Quest:
    """A goal, and for how long it was the newest one."""

    begin: float  # [s]
    end: float  # [s] when the next goal came, or the scenario ended
    x: float  # [m]
    y: float  # [m]

    @property
    def what(self) -> str:
        """The goal in words, for a student."""
        return f"the goal ({self.x:.2f}, {self.y:.2f})"

    def distance(self, pose: Pose) -> float:
        """Return how far the goal is from a pose [m]."""
        return math.hypot(self.x - pose.x, self.y - pose.y)

    def heading_error(self, pose: Pose) -> float:
        """Return the angle to turn by to face the goal [rad], in [-π, π], left positive."""
        bearing = math.atan2(self.y - pose.y, self.x - pose.x)
        return math.remainder(bearing - pose.yaw, math.tau)


def cases(recording: Recording) -> list[Case]:
    """Return the occasions: the start, each tick or pose on the way, each arrival, bad input."""
    run = _Run(recording)
    found = [*run.start(), *run.bad_input()]
    for quest in run.quests:
        drives = recording.scenario.odometry.enabled
        found += [*(run.way(quest) if drives else run.bench(quest)), *run.stop(quest)]
    return sorted(found, key=lambda case: case.at)


def quests(recording: Recording) -> list[Quest]:
    """Return the finite goals in order; the others count for nothing."""
    return [Quest(*row) for row in _spans(_came(recording)["goal"], recording.duration_s)]


def bad_input(recording: Recording) -> dict[str, list[float]]:
    """Return when goals and poses came that are not finite [s]."""
    came = _came(recording).items()
    return {name: [row[0] for row in rows if not _is_finite(row)] for name, rows in came}


def seeking(recording: Recording) -> Iterator[tuple[float, float]]:
    """Yield from when to when the node has something to do [s]: until it knows of its arrival."""
    run = _Run(recording)
    begin = run.ready
    for quest in run.quests:
        end = min(quest.end, run.arrival(quest))
        if end < quest.end or quest is run.quests[-1]:
            yield begin, end
            begin = quest.end


def bench_turns(recording: Recording) -> list[tuple[Quest, Pose, float]]:
    """Return each pose of a bench at which the side is sure, and the turn rate there [rad/s]."""
    run = _Run(recording)
    return [
        (quest, pose, said.get("angular.z", 0.0))
        for quest in run.quests
        for pose, said in run.held(quest)
        if UNSURE < abs(quest.heading_error(pose)) < math.pi - UNSURE
    ]


class _Run:
    """What a node was sent in a trial, what it said, and the occasions that follow from it."""

    def __init__(self, recording: Recording) -> None:
        self.end = recording.duration_s
        self.quests, self.bad = quests(recording), bad_input(recording)
        self.poses = [Pose(*row) for row in _spans(_came(recording)["pose"], self.end)]
        both = self.quests and self.poses
        self.ready = max(self.quests[0].begin, self.poses[0].t) if both else self.end  # [s]
        twists = recording.twists()
        said = (dict(zip(STILL, row, strict=True)) for row in twists.values[:, [0, 5]].tolist())
        self.commands: list[tuple[float, Said]] = list(zip(twists.t.tolist(), said, strict=True))

    def start(self) -> Iterator[Case]:
        """Yield the silence until there are a pose and a goal, and that it ends."""
        early = self.during(0.0, self.ready)
        yield _silence("before", "before the node had both a pose and a goal", early)
        if self.ready < self.end:
            said = {CMD_VEL: "commands"} if self.during(self.ready, self.end) else {}
            yield Case(self.ready, "with a pose and a goal", frozenset({"ready"}), COMMANDS, said)

    def bench(self, quest: Quest) -> Iterator[Case]:
        """Yield the speed and the turn for each pose that held for a tick or longer."""
        for pose, said in self.held(quest):
            straight = abs(quest.heading_error(pose)) < STRAIGHT
            yield _speed(quest, pose.t, pose, said, straight=straight)
            yield from _turn(quest, pose, said)

    def held(self, quest: Quest) -> Iterator[tuple[Pose, Said]]:
        """Yield each pose that held for a tick or longer, and the last command by its end."""
        for same, group in groupby(self.poses, key=attrgetter("x", "y", "yaw")):
            sent = list(group)
            begin, end = max(sent[0].t, quest.begin), min(sent[-1].end, quest.end)
            if begin < min(end - REACTION, self.arrival(quest)):
                yield Pose(begin, end, *same), self.said(begin, end)

    def way(self, quest: Quest) -> Iterator[Case]:
        """Yield the speed of each command on the way, for the farther of the last two poses."""
        begin, end = max(quest.begin, self.ready) + UNHEARD, min(quest.end, self.arrival(quest))
        for t, said in self.during(begin, end):
            count = bisect_right(self.poses, t, key=attrgetter("t"))
            known = self.poses[max(0, count - 2) : count]
            yield _speed(quest, t, max(known, key=quest.distance), said)

    def stop(self, quest: Quest) -> Iterator[Case]:
        """Yield the stop on arrival, and the silence after it."""
        there = self.arrival(quest)
        if quest.end < there + REACTION:
            return
        begin, end = max(quest.begin, there - PERIOD), there + REACTION
        what, tags = f"within {TOLERANCE} m of {quest.what}", frozenset({"stop", "there"})
        right = {name: exactly(number) for name, number in STILL.items()}
        yield Case(there, what, tags, right, self.said(begin, end))
        stops = (t for t, said in self.during(begin, end) if _is_zero(said))
        stopped = next(stops, end)
        after = [(t, said) for t, said in self.during(stopped, quest.end) if t > stopped]
        yield _silence("stop", f"after the stop at {quest.what}", after, there)

    def bad_input(self) -> Iterator[Case]:
        """Yield that nothing changes when a goal or a pose comes that is not finite."""
        for t, name in ((t, name) for name, times in self.bad.items() for t in times):
            if any(t - UNHEARD < quest.begin <= t for quest in self.quests):
                continue  # there is no answer to the good one yet
            was, now = self.said(0.0, t) or STILL, self.said(t + UNHEARD, t + STANDS)
            busy = len(self.during(t - REACTION, t)) > 1  # then silence is a change, too
            allowed = {
                "linear.x": exactly(was["linear.x"]),
                "angular.z": ((was["angular.z"] - STEADY, was["angular.z"] + STEADY),),
            }
            what, said = f"a {name} that is not finite has come", now if busy else now or was
            yield Case(t, what, frozenset({"bad"}), allowed, said)

    def arrival(self, quest: Quest) -> float:
        """Return when the node first knew that it was within the tolerance [s]; inf: never."""
        known = (pose for pose in self.poses if pose.end > quest.begin and pose.t < quest.end)
        there = (pose for pose in known if quest.distance(pose) <= TOLERANCE - MARGIN)
        return next((max(pose.t, quest.begin) for pose in there), math.inf)

    def during(self, begin: float, end: float) -> list[tuple[float, Said]]:
        """Return the commands in [begin, end) [s], with their times."""
        first, last = (bisect_left(self.commands, t, key=itemgetter(0)) for t in (begin, end))
        return self.commands[first:last]

    def said(self, begin: float, end: float) -> Said:
        """Return the last command in [begin, end) [s]; nothing if there was none."""
        found = self.during(begin, end)
        return found[-1][1] if found else {}


def _came(recording: Recording) -> dict[str, Rows]:
    """Return the goals that came, (t [s], x, y [m]) each, and the poses, with a yaw [rad] too."""
    goals, odom = recording.goals(), recording.odometry()
    return {
        "goal": np.column_stack((goals.t, goals.x, goals.y)).tolist(),
        "pose": np.column_stack((odom.t, odom.x, odom.y, odom.yaw)).tolist(),
    }


def _is_finite(row: Sequence[float]) -> bool:
    return all(map(math.isfinite, row))


def _spans(rows: Rows, end: float) -> Rows:
    """Return the finite rows, each with the time of the next one after its own [s]."""
    finite = [row for row in rows if _is_finite(row)]
    ends = [row[0] for row in finite[1:]] + [end]
    return [[row[0], until, *row[1:]] for row, until in zip(finite, ends, strict=False)]


def _is_zero(said: Said) -> bool:
    return all(abs(number) < ZERO for number in said.values())


def _silence(tag: str, what: str, said: Sequence[tuple[float, Said]], at: float = 0.0) -> Case:
    """Return the occasion to say nothing, and how many commands came."""
    return Case(said[0][0] if said else at, what, frozenset({tag}), count=len(said))


def _speed(quest: Quest, at: float, pose: Pose, said: Said, *, straight: bool = False) -> Case:
    """Return the speed that a distance asks for; it may be less where the robot may turn."""
    distance = quest.distance(pose)
    law = min(MAX_SPEED, SPEED_GAIN * distance)
    return Case(
        at=at,
        what=f"{distance:.2f} m from {quest.what}" + ", straight ahead" * straight,
        tags=frozenset({"speed"}),
        allowed={"linear.x": exactly(law) if straight else ((0.0, law),)},
        said={"linear.x": said["linear.x"]} if said else {},
    )


def _turn(quest: Quest, pose: Pose, said: Said) -> Iterator[Case]:
    """Yield the side to turn to, unless either is right."""
    error, rate = quest.heading_error(pose), said.get("angular.z", 0.0)
    if UNSURE < abs(error) < math.pi - UNSURE:
        side = "left" if error > 0 else "right"
        turned = "left" if rate > TURNS else "right" if rate < -TURNS else "none"
        yield Case(
            at=pose.t,
            what=f"{quest.what}, {abs(error):.2f} rad to the {side} of where the robot looks",
            tags=frozenset({"turn"}),
            allowed={"turn": frozenset({side})},
            said={"turn": turned} if said else {},
        )
