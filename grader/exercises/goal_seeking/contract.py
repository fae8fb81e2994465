"""The oracle of goal_seeking: what its contract asks for, from recorded poses and goals."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from grader.checks.contract import Contract, Limits, Survived
from grader.recording import Recording

TOLERANCE = 0.5  # [m] within this distance a goal is reached
MAX_SPEED = 0.3  # [m/s]
MAX_TURN_RATE = 1.9  # [rad/s]
SPEED_GAIN = 0.5  # [1/s]
PERIOD = 0.1  # [s] of the control loop
HAIR = 0.001  # [m] distances this near to the tolerance may fall on either side

CONTRACT = Contract(
    limits=Limits(fastest=0.3, turning=1.9),
    period=0.1,
    goals=True,
    delayed_in=("goal_across_the_seam", "goal_behind", "goal_beside"),
    survives=Survived(sensors=300, commands=300),
)


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
    note: str = ""  # what it says about itself, in words

    @property
    def what(self) -> str:
        """The goal in words, for a student."""
        return f"the goal ({self.x:.2f}, {self.y:.2f}){self.note}"

    def distance(self, pose: Pose) -> float:
        """Return how far the goal is from a pose [m]."""
        return math.hypot(self.x - pose.x, self.y - pose.y)

    def heading_error(self, pose: Pose) -> float:
        """Return the angle to turn by to face the goal [rad], in [-π, π], left positive."""
        bearing = math.atan2(self.y - pose.y, self.x - pose.x)
        return math.remainder(bearing - pose.yaw, math.tau)


class Frame(Enum):
    """What a node takes a goal's two numbers for."""

    ODOM = "x and y in the frame odom"  # as the contract has it
    SWAPPED = "y and x"
    ROBOT = "an offset from where the robot is when the goal comes"


def quests(recording: Recording, frame: Frame = Frame.ODOM) -> list[Quest]:
    """Return the finite goals in order, as taken in this frame; the others count for nothing."""
    goals = recording.goals()
    finite = np.isfinite(goals.x) & np.isfinite(goals.y)
    rows = np.column_stack((goals.t, goals.x, goals.y))[finite].tolist()
    ends = [row[0] for row in rows[1:]] + [recording.duration_s]
    sent = [Quest(t, end, x, y) for (t, x, y), end in zip(rows, ends, strict=False)]
    return sent if frame is Frame.ODOM else [_taken(recording, quest, frame) for quest in sent]


def _taken(recording: Recording, quest: Quest, frame: Frame) -> Quest:
    """Return what a goal is to a node that takes it for something else."""
    x, y = quest.y, quest.x
    if frame is Frame.ROBOT:
        known = [pose for pose in poses(recording) if pose.t <= quest.begin][-1:]
        x = quest.x + sum(pose.x for pose in known)
        y = quest.y + sum(pose.y for pose in known)
    note = f", which is what your node takes ({quest.x:.2f}, {quest.y:.2f}) for"
    return replace(quest, x=x, y=y, note=note)


def poses(recording: Recording) -> list[Pose]:
    """Return the finite poses in order; the others count for nothing."""
    odom = recording.odometry()
    finite = np.isfinite(odom.x) & np.isfinite(odom.y) & np.isfinite(odom.yaw)
    rows = np.column_stack((odom.t, odom.x, odom.y, odom.yaw))[finite]
    return [Pose(*row) for row in rows.tolist()]


def ready_at(recording: Recording) -> float:
    """Return when the node had both a pose and a goal [s]; inf: never."""
    goals, told = quests(recording), poses(recording)
    return max(goals[0].begin, told[0].t) if goals and told else math.inf


def arrival(recording: Recording, quest: Quest) -> float | None:
    """Return when the node first knew that it was within the tolerance of a goal [s], if ever."""
    known = poses(recording)
    before = [pose for pose in known if pose.t <= quest.begin][-1:]
    during = [pose for pose in known if quest.begin < pose.t < quest.end]
    for pose in before + during:
        if quest.distance(pose) <= TOLERANCE - HAIR:
            return max(pose.t, quest.begin)
    return None


def speed_law(distance: float) -> float:
    """Return the forward speed [m/s] for a distance to go [m]."""
    return min(MAX_SPEED, SPEED_GAIN * distance)
