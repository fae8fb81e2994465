"""The oracle of goal_seeking: what its contract asks for, from recorded poses and goals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grader.checks.case import Case, exactly
from grader.checks.commands import is_zero
from grader.checks.contract import Contract, Limits, Survived
from grader.recording import Recording
from grader.recording.views import Goals, Odom
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
INSTANT = 1e-9  # [s]
STEADY = 0.1  # [rad/s] either way of a robot that looks straight at its goal

CONTRACT = Contract(
    limits=Limits(fastest=MAX_SPEED, turning=MAX_TURN_RATE),
    period=PERIOD,
    goals=True,
    delayed_in=("goal_across_the_seam", "goal_behind", "goal_beside"),
    survives=Survived(sensors=300, commands=300),
)
STILL = {"linear.x": 0.0, "angular.z": 0.0}  # [m/s] and [rad/s]
COMMANDS = {CMD_VEL: frozenset({"commands"})}  # whatever they say
STOP = {name: exactly(number) for name, number in STILL.items()}


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
    rows = np.column_stack((goals.t, goals.x, goals.y))[finite(goals)].tolist()
    ends = [row[0] for row in rows[1:]] + [recording.duration_s]
    return [Quest(t, end, x, y) for (t, x, y), end in zip(rows, ends, strict=False)]


def poses(recording: Recording) -> list[Pose]:
    """Return the finite poses in order; the others count for nothing."""
    odom = recording.odometry()
    rows = np.column_stack((odom.t, odom.x, odom.y, odom.yaw))[finite(odom)].tolist()
    return [Pose(*row) for row in rows]


def bad_input(recording: Recording) -> dict[str, list[float]]:
    """Return when goals and poses came that are not finite [s]."""
    came: dict[str, Goals | Odom] = {"goal": recording.goals(), "pose": recording.odometry()}
    return {what: view.t[~finite(view)].tolist() for what, view in came.items()}


def finite(view: Goals | Odom) -> NDArray[np.bool_]:
    """Return which goals or poses are finite, (n,)."""
    numbers = (view.x, view.y, view.yaw) if isinstance(view, Odom) else (view.x, view.y)
    found: NDArray[np.bool_] = np.all(np.isfinite(numbers), axis=0)
    return found


def seeking(recording: Recording) -> list[tuple[float, float]]:
    """Return from when to when the node has something to do [s]: until it knows of its arrival."""
    run = _Run(recording)
    spans: list[tuple[float, float]] = []
    for quest in run.quests:
        begin, end = max(quest.begin, run.ready), run.way_ends(quest)
        if spans and spans[-1][1] == quest.begin:  # on the way to another goal
            begin = spans.pop()[0]
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
        self.bad = bad_input(recording)
        self.twists, self.end = recording.twists(), recording.duration_s
        self.stops = set(self.twists.t[np.all(is_zero(self.twists.values), axis=1)].tolist())
        both = self.quests and self.poses
        self.ready = max(self.quests[0].begin, self.poses[0].t) if both else self.end  # [s]

    def start(self) -> Iterator[Case]:
        """Yield the silence until there are a pose and a goal, and that it ends."""
        early = self.times(0.0, self.ready)
        yield _silence("before", "before the node had both a pose and a goal", early)
        if self.ready < self.end:
            yield Case(
                at=self.ready,
                what="with a pose and a goal",
                tags=frozenset({"ready"}),
                allowed=COMMANDS,
                said={CMD_VEL: "commands"} if self.said(self.ready, self.end) else {},
            )

    def holds(self, quest: Quest) -> Iterator[Case]:
        """Yield a speed and a turn for each pose of a bench that held for a tick or longer."""
        ends = [pose.t for pose in self.poses[1:]] + [self.end]
        for pose, end in zip(self.poses, ends, strict=False):
            until = min(end, quest.end)
            if quest.begin <= pose.t < min(until - REACTION, self.way_ends(quest)):
                said = self.said(pose.t, until)
                yield _speed(quest, pose.t, [pose], said)
                yield from _turn(quest, pose.t, pose, said)

    def way(self, quest: Quest) -> Iterator[Case]:
        """Yield a speed for each command on the way to a goal, and the side of the first turn."""
        on_the_way = self.times(max(quest.begin + UNHEARD, self.ready), self.way_ends(quest))
        said = {t: self.said(t, t + INSTANT) for t in on_the_way}
        for t in on_the_way:
            yield _speed(quest, t, self.known(t), said[t])
        turns = [t for t in on_the_way if abs(said[t]["angular.z"]) > TURNS] or on_the_way
        for t in turns[:1]:
            yield from _turn(quest, t, self.known(t)[-1], said[t])

    def stop(self, quest: Quest) -> Iterator[Case]:
        """Yield where the first stop has to be, the stop on arrival, and the silence after it."""
        during = self.times(max(quest.begin, self.ready), quest.end)
        moving = [t for t in during if t not in self.stops]
        stops = [t for t in during if t in self.stops and t > min(moving, default=0.0)]
        for t in stops[:1]:
            yield Case(
                at=t,
                what=f"the first zero Twist on the way to {quest.what}",
                tags=frozenset({"stop"}),
                allowed={"distance [m]": ((0.0, TOLERANCE + MARGIN),)},
                said={"distance [m]": quest.distance(self.known(t)[-1])},
            )
        there = self.arrival(quest)
        if there is None or quest.end < there + REACTION:
            return
        begin, end = max(quest.begin, there - PERIOD), there + REACTION
        yield Case(
            at=there,
            what=f"within {TOLERANCE} m of {quest.what}",
            tags=frozenset({"stop", "there"}),
            allowed=STOP,
            said=self.said(begin, end),
        )
        stopped = next((t + INSTANT for t in stops if t >= begin), end)
        after = self.times(stopped, quest.end)
        yield _silence("stop", f"after the stop at {quest.what}", after, there)

    def bad_input(self) -> Iterator[Case]:
        """Yield that nothing changes when a goal or a pose comes that is not finite."""
        for t, name in sorted((t, name) for name, times in self.bad.items() for t in times):
            what, tags = f"a {name} that is not finite has come", frozenset({"bad"})
            was, now = self.said(0.0, t) or STILL, self.said(t + UNHEARD, t + STANDS)
            if any(t - UNHEARD < quest.begin <= t for quest in self.quests):
                what += ", right after a good one"
                yield Case(t, what, tags, COMMANDS, {CMD_VEL: "commands"} if now else {})
                continue
            busy = len(self.times(t - REACTION, t)) > 1  # then silence is a change, too
            allowed = {
                "linear.x": exactly(was["linear.x"]),
                "angular.z": ((was["angular.z"] - STEADY, was["angular.z"] + STEADY),),
            }
            yield Case(t, what, tags, allowed, now if busy else now or was)

    def way_ends(self, quest: Quest) -> float:
        """Return when the node knew that it was there [s], or another goal came."""
        there = self.arrival(quest)
        return quest.end if there is None else there

    def arrival(self, quest: Quest) -> float | None:
        """Return when the node first knew that it was within the tolerance of a goal [s]."""
        first = max(0, int(np.searchsorted(self.heard, quest.begin, side="right")) - 1)
        for pose in self.poses[first : int(np.searchsorted(self.heard, quest.end))]:
            if quest.distance(pose) <= TOLERANCE - MARGIN:
                return max(pose.t, quest.begin)
        return None

    def known(self, time: float) -> list[Pose]:
        """Return the last two poses that the node had been sent at a time [s]."""
        count = int(np.searchsorted(self.heard, time, side="right"))
        return self.poses[max(0, count - 2) : count]

    def times(self, begin: float, end: float) -> list[float]:
        """Return when commands came in [begin, end) [s]."""
        first, last = np.searchsorted(self.twists.t, (begin, end)).tolist()
        return [float(t) for t in self.twists.t[first:last]]

    def said(self, begin: float, end: float) -> Mapping[str, float]:
        """Return the last command in [begin, end); nothing if there was none."""
        first, last = np.searchsorted(self.twists.t, (begin, end)).tolist()
        if first == last:
            return {}
        return dict(zip(STILL, self.twists.values[last - 1, [0, 5]].tolist(), strict=True))


def _silence(tag: str, what: str, times: Sequence[float], at: float = 0.0) -> Case:
    """Return the occasion to say nothing, and the times [s] at which the node did."""
    return Case(at=times[0] if times else at, what=what, tags=frozenset({tag}), count=len(times))


def _speed(quest: Quest, at: float, known: Sequence[Pose], said: Mapping[str, float]) -> Case:
    """Return the speed that a distance asks for, that of the farther of the poses.

    It is the law's for a robot that has one pose for a while and looks straight at its goal; it may
    be less, but never below zero, where the robot turns.
    """
    distance = max(quest.distance(pose) for pose in known)
    straight = len(known) == 1 and abs(quest.heading_error(known[0])) < STRAIGHT
    law = speed_law(distance)
    return Case(
        at=at,
        what=f"{distance:.2f} m from {quest.what}" + ", straight ahead" * straight,
        tags=frozenset({"speed"}),
        allowed={"linear.x": exactly(law) if straight else ((0.0, law),)},
        said={"linear.x": said["linear.x"]} if said else {},
    )


def _turn(quest: Quest, at: float, pose: Pose, said: Mapping[str, float]) -> Iterator[Case]:
    """Yield the side to turn to, unless either is right."""
    error = quest.heading_error(pose)
    if UNSURE < abs(error) < math.pi - UNSURE:
        side = "left" if error > 0 else "right"
        yield Case(
            at=at,
            what=f"{quest.what}, {abs(error):.2f} rad to the {side} of where the robot looks",
            tags=frozenset({"turn"}),
            allowed={"turn": frozenset({side})},
            said={"turn": _side(said["angular.z"])} if said else {},
        )


def _side(rate: float) -> str:
    if math.isnan(rate):
        return "NaN"
    return "none" if abs(rate) <= TURNS else "left" if rate > 0 else "right"
