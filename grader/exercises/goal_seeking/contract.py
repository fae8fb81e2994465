"""The oracle of goal_seeking: what its contract asks for, from recorded poses and goals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from grader.checks.case import Case, Said, exactly
from grader.checks.commands import is_zero
from grader.checks.contract import Contract, Limits, Survived
from grader.recording import Floats, Recording
from sim.messages import CMD_VEL_TOPIC as CMD_VEL

TOLERANCE = 0.5  # [m] within this distance a goal is reached
MAX_SPEED = 0.3  # [m/s]
MAX_TURN_RATE = 1.9  # [rad/s]
SPEED_GAIN = 0.5  # [1/s]
PERIOD = 0.1  # [s] of the control loop
HAIR = 0.001  # [m] distances this near to the tolerance may fall on either side
REACTION = 2.5 * PERIOD  # [s] long enough for a tick of the control loop, even at 5 Hz
UNHEARD = 0.05  # [s] a command that comes so soon after a goal need not be about it
STANDS = 0.3  # [s] for which a bad message is the newest one
STRAIGHT = 0.01  # [rad] from the goal: the robot has no reason to turn
UNSURE = 0.2  # [rad] from ahead and from behind, where a turn to either side is right
TURNS = 1e-3  # [rad/s]
INSTANT = 1e-9  # [s]
STEADY = 0.1  # [rad/s] either way of a robot that looks straight at its goal

CONTRACT = Contract(
    limits=Limits(fastest=MAX_SPEED, turning=MAX_TURN_RATE),
    period=PERIOD,
    goals=True,
    delayed_in=("goal_across_the_seam", "goal_behind", "goal_beside"),
    survives=Survived(sensors=300, commands=300),
)
STOP = {"linear.x": exactly(0.0), "angular.z": exactly(0.0)}


@dataclass(frozen=True)
class Pose:
    """A pose that the node was sent."""

    t: float  # [s] when it arrived
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
    """Return the occasions: the start, each pose or tick on the way, each arrival, bad input."""
    run = _Run(recording)
    found = [*run.start(), *run.bad_input()]
    for quest in run.quests:
        found += run.way(quest) if recording.scenario.odometry.enabled else run.holds(quest)
        found += run.stop(quest)
    return sorted(found, key=lambda case: case.at)


def quests(recording: Recording) -> list[Quest]:
    """Return the finite goals in order; the others count for nothing."""
    goals = recording.goals()
    finite = np.isfinite(goals.x) & np.isfinite(goals.y)
    rows = np.column_stack((goals.t, goals.x, goals.y))[finite].tolist()
    ends = [row[0] for row in rows[1:]] + [recording.duration_s]
    return [Quest(t, end, x, y) for (t, x, y), end in zip(rows, ends, strict=False)]


def poses(recording: Recording) -> list[Pose]:
    """Return the finite poses in order; the others count for nothing."""
    odom = recording.odometry()
    finite = np.isfinite(odom.x) & np.isfinite(odom.y) & np.isfinite(odom.yaw)
    rows = np.column_stack((odom.t, odom.x, odom.y, odom.yaw))[finite]
    return [Pose(*row) for row in rows.tolist()]


def bad_input(recording: Recording) -> dict[str, Floats]:
    """Return when goals and poses came that are not finite [s], each (n,)."""
    goals, odom = recording.goals(), recording.odometry()
    return {
        "goal": goals.t[~(np.isfinite(goals.x) & np.isfinite(goals.y))],
        "pose": odom.t[~(np.isfinite(odom.x) & np.isfinite(odom.y) & np.isfinite(odom.yaw))],
    }


def seeking(recording: Recording) -> list[tuple[float, float]]:
    """Return from when to when the node has something to do [s]: until it knows of its arrival."""
    run = _Run(recording)
    spans: list[tuple[float, float]] = []
    for quest in run.quests:
        begin, there = max(quest.begin, run.ready), run.arrival(quest)
        end = quest.end if there is None else there
        if spans and spans[-1][1] == quest.begin:
            begin = spans.pop()[0]
        if begin < end:
            spans.append((begin, end))
    return spans


def speed_law(distance: float) -> float:
    """Return the forward speed [m/s] for a distance to go [m]."""
    return min(MAX_SPEED, SPEED_GAIN * distance)


class _Run:
    """What a node was sent in a trial, what it said, and the occasions that follow from it."""

    def __init__(self, recording: Recording) -> None:
        self.quests, self.poses = quests(recording), poses(recording)
        self.heard = np.array([pose.t for pose in self.poses])  # (n,) [s]
        self.bad = {t: name for name, times in bad_input(recording).items() for t in times.tolist()}
        self.twists, self.end = recording.twists(), recording.duration_s
        self.zero = np.all(is_zero(self.twists.values), axis=1)
        both = self.quests and self.poses
        self.ready = max(self.quests[0].begin, self.poses[0].t) if both else math.inf  # [s]

    def start(self) -> Iterator[Case]:
        """Yield the silence until there are a pose and a goal, and that it ends."""
        early = self.times(0.0, self.ready)
        yield Case(
            at=float(early[0]) if len(early) else 0.0,
            what="before the node had both a pose and a goal",
            tags=frozenset({"before"}),
            count=len(early),
        )
        if self.ready < self.end:
            count = len(self.times(self.ready, self.end))
            yield Case(
                at=self.ready,
                what="with a pose and a goal",
                tags=frozenset({"ready"}),
                allowed={CMD_VEL: frozenset({"commands"})},
                said={CMD_VEL: "commands"} if count else {},
                count=count,
            )

    def holds(self, quest: Quest) -> Iterator[Case]:
        """Yield a speed and a turn for each pose of a bench that held for a tick or longer."""
        there = self.arrival(quest)
        ends = [pose.t for pose in self.poses[1:]] + [self.end]
        for pose, end in zip(self.poses, ends, strict=False):
            begin, until = max(pose.t, quest.begin), min(end, quest.end)
            if pose.t < quest.begin or until - begin <= REACTION:
                continue
            if there is None or pose.t < there:
                said = self.said(begin, until)
                yield _speed(quest, begin, [pose], said)
                yield from _turn(quest, begin, pose, said)

    def way(self, quest: Quest) -> Iterator[Case]:
        """Yield a speed for each command on the way to a goal, and the side of the first turn."""
        there = self.arrival(quest)
        on_the_way = self.times(quest.begin + UNHEARD, quest.end if there is None else there)
        for t in on_the_way.tolist():
            if known := self.known(t):
                yield _speed(quest, t, known, self.said(t, t + INSTANT))
        during = self.times(quest.begin, quest.end)
        rates = self.twists.angular_z[np.isin(self.twists.t, during)]
        first = during[np.abs(rates) > TURNS][:1].tolist() or during[:1].tolist()
        for t in first:
            if known := self.known(t):
                yield from _turn(quest, t, known[-1], self.said(t, t + INSTANT))

    def stop(self, quest: Quest) -> Iterator[Case]:
        """Yield where the first stop has to be, the stop on arrival, and the silence after it."""
        during = (self.twists.t >= quest.begin) & (self.twists.t < quest.end)
        moving = self.twists.t[during & ~self.zero]
        begin = moving[0] if len(moving) else quest.begin
        stops = self.twists.t[during & self.zero & (self.twists.t >= begin)].tolist()
        for stop in stops[:1]:
            for pose in self.known(stop)[-1:]:
                yield Case(
                    at=stop,
                    what=f"the first zero Twist on the way to {quest.what}",
                    tags=frozenset({"stop"}),
                    allowed={"distance [m]": ((0.0, TOLERANCE + HAIR),)},
                    said={"distance [m]": quest.distance(pose)},
                )
        there = self.arrival(quest)
        if there is None or quest.end < there + REACTION:
            return
        near = [stop for stop in stops if stop >= there or self.is_near(quest, stop)]
        stopped = min([there, *near])
        yield Case(
            at=there,
            what=f"within {TOLERANCE} m of {quest.what}",
            tags=frozenset({"stop", "there"}),
            allowed=STOP,
            said=self.said(stopped, there + REACTION),
        )
        after = self.times(near[0] + INSTANT if near else there + REACTION, quest.end)
        yield Case(
            at=float(after[0]) if len(after) else there,
            what=f"after the stop at {quest.what}",
            tags=frozenset({"stop"}),
            count=len(after),
        )

    def bad_input(self) -> Iterator[Case]:
        """Yield that nothing changes when a goal or a pose comes that is not finite."""
        for t, name in self.bad.items():
            goals = [quest for quest in self.quests if quest.begin <= t]
            there = self.arrival(goals[-1]) if goals else None
            what, tags = f"a {name} that is not finite has come", frozenset({"bad"})
            if t < self.ready or (there is not None and there <= t):
                said = self.said(0.0, t + STANDS) or {"linear.x": 0.0, "angular.z": 0.0}
                yield Case(t, f"{what}, with no goal to drive to", tags, STOP, said)
                continue
            goal, pose = goals[-1], self.known(t)[-1]
            allowed = {
                "linear.x": exactly(speed_law(goal.distance(pose))),
                "angular.z": ((-STEADY, STEADY),),
            }
            what = f"{what}, on the way straight to {goal.what}"
            yield Case(t, what, tags, allowed, self.said(t, t + STANDS))

    def arrival(self, quest: Quest) -> float | None:
        """Return when the node first knew that it was within the tolerance of a goal [s]."""
        first = max(0, int(np.searchsorted(self.heard, quest.begin, side="right")) - 1)
        for pose in self.poses[first : int(np.searchsorted(self.heard, quest.end))]:
            if quest.distance(pose) <= TOLERANCE - HAIR:
                return max(pose.t, quest.begin)
        return None

    def is_near(self, quest: Quest, time: float) -> bool:
        """Return whether the pose known at a time [s] was, but for a hair, within the tolerance."""
        return any(quest.distance(pose) <= TOLERANCE + HAIR for pose in self.known(time)[-1:])

    def known(self, time: float) -> list[Pose]:
        """Return the last two poses that the node had been sent at a time [s]."""
        count = int(np.searchsorted(self.heard, time, side="right"))
        return self.poses[max(0, count - 2) : count]

    def times(self, begin: float, end: float) -> Floats:
        """Return when commands came in [begin, end) [s], (n,)."""
        t = self.twists.t
        times: Floats = t[(t >= begin) & (t < end)]
        return times

    def said(self, begin: float, end: float) -> dict[str, Said]:
        """Return the last command in [begin, end); nothing if there was none."""
        inside = np.flatnonzero((self.twists.t >= begin) & (self.twists.t < end))[-1:]
        return {
            name: float(numbers[i])
            for i in inside
            for name, numbers in (
                ("linear.x", self.twists.linear_x),
                ("angular.z", self.twists.angular_z),
            )
        }


def _speed(quest: Quest, at: float, known: list[Pose], said: Mapping[str, Said]) -> Case:
    """Return the speed that a distance asks for, that of the farthest of the poses.

    It is the law's for a robot that was told one pose for a while and looks straight at its goal;
    it may be less, but never below zero, where a robot turns.
    """
    distance = max(quest.distance(pose) for pose in known)
    straight = len(known) == 1 and abs(quest.heading_error(known[0])) < STRAIGHT
    law = speed_law(distance)
    return Case(
        at=at,
        what=f"{distance:.2f} m from {quest.what}" + ", straight ahead" * straight,
        tags=frozenset({"speed"}),
        allowed={"linear.x": exactly(law) if straight else ((0.0, law),)},
        said={name: said[name] for name in ("linear.x",) if said},
    )


def _turn(quest: Quest, at: float, pose: Pose, said: Mapping[str, Said]) -> Iterator[Case]:
    """Yield the side to turn to, unless either is right."""
    error = quest.heading_error(pose)
    if UNSURE < abs(error) < math.pi - UNSURE:
        side = "left" if error > 0 else "right"
        yield Case(
            at=at,
            what=f"{quest.what}, {abs(error):.2f} rad to the {side} of where the robot looks",
            tags=frozenset({"turn"}),
            allowed={"turn": frozenset({side})},
            said={"turn": _side(float(said["angular.z"]))} if said else {},
        )


def _side(rate: float) -> str:
    if math.isnan(rate):
        return "NaN"
    return "none" if abs(rate) <= TURNS else "left" if rate > 0 else "right"
