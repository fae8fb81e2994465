"""What happened in one trial, frozen: the only thing that checks and reports ever see.

A recording holds every message that crossed the link, the simulator's ground truth, the node's
endpoints and log, and how the node ended. The checks' verdict depends on nothing else, so a
recording can be saved as a bag (see grader.recording.bag), loaded and judged again without running
any student's code.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import msgspec
import numpy as np
from numpy.typing import NDArray

from grader.host.frames import Tensor
from grader.link.log import LogLine
from sim.layout import Layout, layout_to_json
from sim.messages import (
    EPOCH_NS,
    LASER_SCAN,
    ODOMETRY,
    POSE_STAMPED,
    Message,
    decode,
    twist_from_cdr,
)
from sim.scenario import Scenario
from sim.simulation import Truth

Floats = NDArray[np.float64]

COMPLETED = "completed"


@dataclass(frozen=True)
class Outcome:
    """How the node's program ended.

    `kind` is `completed` (the scenario ran to its end with the node alive) or one of
    `missing` (a file of the submission), `unreadable`, `syntax_error`, `exception`, `returned`,
    `exited` (sys.exit), `died` (the process vanished), `hung` (no answer within the wall time),
    `stuck` (a deadlock), `never_spun`, `flooded`, `forged`, `real_time` (it can't run in virtual
    time, and has to run again).
    """

    kind: str
    text: str = ""  # one line for the student
    at: float = 0.0  # [s] since the scenario's start
    detail: str = ""  # a traceback or stacks, in full

    @property
    def completed(self) -> bool:
        """The node lived to the end."""
        return self.kind == COMPLETED


class Endpoint(msgspec.Struct, frozen=True):
    """A publisher, subscription, service or client that the node created."""

    kind: str
    node: str
    topic: str
    type: str
    reliability: str = ""
    durability: str = ""
    depth: int = 0
    mismatch: str = ""  # why it and the robot's end of the topic can't talk; "" if they can

    @property
    def matched(self) -> bool:
        """It can talk to the robot's end of the topic (or the robot has none)."""
        return not self.mismatch


@dataclass(frozen=True)
class Compute:
    """What each exchange with the host cost; measured by the judge, different on each machine."""

    time: Floats  # (n,) [s] scenario time at which it began
    wall: Floats  # (n,) [s]
    cpu: Floats  # (n,) [s] of the host's process; nan where the system doesn't tell
    queued: Floats  # (n,) [s] waited for a CPU, by host or judge; measured only if wall >> cpu


class ScriptRun(msgspec.Struct, frozen=True):
    """One run of a training script."""

    kind: str  # returned, exited, exception, syntax_error, died, hung, forged
    text: str  # one line for the student
    detail: str  # a traceback
    wall: float  # [s]
    files: dict[str, int]  # what it was to write: size [bytes]; missing if it wrote none

    @property
    def succeeded(self) -> bool:
        """The script came to its end without an error."""
        return self.kind == "returned" or self.text in ("sys.exit()", "sys.exit(0)")


class ModelAnswers(msgspec.Struct, frozen=True):
    """What one trained model said about the hidden scans."""

    problem: str = ""  # why it could not be loaded, or what predict raised
    loaded: bool = False
    shape: tuple[int, ...] = ()
    values: bytes = b""  # float64 [m/s]

    @property
    def speeds(self) -> Floats:
        """(n,) predictions [m/s]."""
        return np.frombuffer(self.values[: len(self.values) // 8 * 8])


class Training(msgspec.Struct, frozen=True):
    """What a training script made; the part of a recording that a `[training]` scenario has."""

    script: str
    problem: str = ""  # why it was not run at all
    runs: tuple[ScriptRun, ...] = ()  # two on the same data
    pickle: ModelAnswers = ModelAnswers()
    again: ModelAnswers = ModelAnswers()  # the second run's
    onnx: ModelAnswers = ModelAnswers()
    onnx_inputs: tuple[Tensor, ...] = ()
    onnx_outputs: tuple[Tensor, ...] = ()
    labels: bytes = b""  # float64, the expert's speeds [m/s]
    single_wall: bytes = b""  # float64, of predictions for one scan each [s]
    single_cpu: bytes = b""

    @property
    def expert(self) -> Floats:
        """(n,) speeds that the expert chose for the hidden scans [m/s]."""
        return np.frombuffer(self.labels)


class Live(msgspec.Struct, frozen=True):
    """What a trial in real time adds to a recording."""

    epoch: int  # [ns] since 1970 at the scenario's start
    reason: str  # why it was not in virtual time; "" if real time was asked for
    lateness: float  # [s] of the robot's latest message
    starved: float  # [s] that a thread of the node waited for a CPU, at worst
    stall: str = ""  # what the machine did that makes the recording worthless; "" if nothing


@dataclass(frozen=True)
class Twists:
    """The Twist messages of one topic."""

    t: Floats  # (n,) [s]
    values: Floats  # (n, 6) linear x, y, z [m/s], angular x, y, z [rad/s]

    @property
    def linear_x(self) -> Floats:
        """Forward speed, (n,) [m/s]."""
        return self.values[:, 0]

    @property
    def angular_z(self) -> Floats:
        """Turning speed, positive to the left, (n,) [rad/s]."""
        return self.values[:, 5]


@dataclass(frozen=True, eq=False)
class Scan:
    """One LaserScan as the node got it."""

    t: float  # [s] scenario time of delivery
    stamp: float  # [s] scenario time in its header
    angle_min: float  # [rad]
    angle_increment: float  # [rad]
    range_min: float  # [m]
    range_max: float  # [m]
    ranges: NDArray[np.float32]  # (n_beams,) [m]

    @property
    def angles(self) -> Floats:
        """Beam angles, (n_beams,) [rad], as the message says."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges), dtype=float)


@dataclass(frozen=True)
class Odom:
    """The Odometry messages of one topic."""

    t: Floats  # (n,) [s]
    x: Floats  # (n,) [m]
    y: Floats  # (n,) [m]
    yaw: Floats  # (n,) [rad]
    v: Floats  # (n,) [m/s]
    w: Floats  # (n,) [rad/s]


@dataclass(frozen=True)
class Goals:
    """The goals that the node was given."""

    t: Floats  # (n,) [s]
    x: Floats  # (n,) [m]
    y: Floats  # (n,) [m]


@dataclass(frozen=True, eq=False)
class Recording:
    """One trial."""

    scenario: Scenario
    layout: Layout
    seed: int
    duration_s: float  # [s] simulated; shorter than the scenario's if the node ended
    delivered: tuple[Message, ...]  # robot to node, in order
    published: tuple[Message, ...]  # node to robot, in order
    truth: Truth
    outcome: Outcome
    endpoints: tuple[Endpoint, ...]
    log: tuple[LogLine, ...] = ()
    log_truncated: bool = False
    compute: Compute = field(default_factory=lambda: Compute(*(np.empty(0),) * 4))
    training: Training | None = None
    live: Live | None = None  # None: in virtual time
    bag: str | None = None  # where it is saved

    @property
    def name(self) -> str:
        """The scenario's name."""
        return self.scenario.name

    @property
    def epoch(self) -> int:
        """ROS time at the scenario's start [ns]."""
        return EPOCH_NS if self.live is None else self.live.epoch

    @property
    def slack(self) -> float:
        """How much a time limit yields to the machine [s]; 0 in virtual time.

        In real time it is what this trial measured: how late the robot's latest message left, and
        how long the node waited for a CPU. Longer than a moment is a stall (`live.stall`).
        """
        return 0.0 if self.live is None else self.live.lateness + self.live.starved

    def delay(self, begin: float, end: float) -> float:
        """Return how much of the time from a message of the robot to an answer went to the machine.

        0 in virtual time. In real time: how late the robot's latest message left, and how long the
        node had to wait for a CPU meanwhile [s].
        """
        return self.waited(begin, end) + (self.live.lateness if self.live else 0.0)

    def waited(self, begin: float, end: float) -> float:
        """Return the longest that the node had to wait for a CPU between two moments [s].

        0 in virtual time. For what `slack`, the worst of a whole trial, would blur too much.
        """
        if self.live is None:
            return 0.0
        first = max(0, int(np.searchsorted(self.compute.time, begin, side="right")) - 1)
        last = int(np.searchsorted(self.compute.time, end))
        return float(self.compute.queued[first:last].max(initial=0.0))

    @cached_property
    def messages(self) -> tuple[Message, ...]:
        """Everything that crossed the link, in order of time."""
        return tuple(sorted(self.delivered + self.published, key=lambda message: message.time))

    def of(self, topic: str) -> tuple[Message, ...]:
        """Return the messages of one topic."""
        return tuple(message for message in self.messages if message.topic == topic)

    def times(self, topic: str) -> Floats:
        """Return when the messages of a topic crossed the link, (n,) [s]."""
        return np.array([message.time for message in self.of(topic)], dtype=float) / 1e9

    def twists(self, topic: str = "/cmd_vel") -> Twists:
        """Return the node's Twist messages; what is not a Twist is left out."""
        return self._twists(topic)

    def scans(self, topic: str = "/scan") -> tuple[Scan, ...]:
        """Return the scans that the node was sent."""
        return self._scans

    def odometry(self, topic: str = "/odom") -> Odom:
        """Return the odometry that the node was sent."""
        return self._odometry

    def goals(self, topic: str = "/goal_pose") -> Goals:
        """Return the goals that the node was sent."""
        rows = []
        for message in self._delivered_on(topic, POSE_STAMPED):
            position = decode(message.data, POSE_STAMPED).pose.position
            rows.append((message.time / 1e9, position.x, position.y))
        return Goals(*np.array(rows, dtype=float).reshape(-1, 3).T)

    def digest(self) -> str:
        """Return a fingerprint of all that must be the same in every run of the same node.

        The text of the log and the measured compute times are left out.
        """
        result = hashlib.sha256(layout_to_json(self.layout).encode())
        for message in (*self.delivered, *self.published):
            result.update(f"{message.time} {message.topic} {message.type}".encode())
            result.update(message.data)
        truth = self.truth
        for array in (truth.t, truth.x, truth.y, truth.yaw, truth.v, truth.w, truth.clearance):
            result.update(array.tobytes())
        result.update(truth.contact.tobytes())
        result.update(msgspec.json.encode(self.endpoints))
        if self.training is not None:
            for answers in (self.training.pickle, self.training.again, self.training.onnx):
                result.update(answers.values)
        result.update(f"{self.outcome.kind} {self.outcome.at:.9f} {self.seed}".encode())
        return result.hexdigest()

    # --- decoded once ----------------------------------------------------------------------------

    def _delivered_on(self, topic: str, type: str) -> Iterator[Message]:
        return (m for m in self.delivered if m.topic == topic and m.type == type)

    @cached_property
    def _twist_cache(self) -> dict[str, Twists]:
        return {}

    def _twists(self, topic: str) -> Twists:
        if topic not in self._twist_cache:
            times, values = [], []
            for message in self.published:
                if message.topic != topic:
                    continue
                try:
                    values.append(twist_from_cdr(message.data))
                except ValueError:
                    continue
                times.append(message.time / 1e9)
            self._twist_cache[topic] = Twists(
                np.array(times, dtype=float), np.array(values, dtype=float).reshape(-1, 6)
            )
        return self._twist_cache[topic]

    @cached_property
    def _scans(self) -> tuple[Scan, ...]:
        messages = self._delivered_on("/scan", LASER_SCAN)
        return tuple(_scan(message, self.epoch) for message in messages)

    @cached_property
    def _odometry(self) -> Odom:
        rows = [_odometry_row(message) for message in self._delivered_on("/odom", ODOMETRY)]
        return Odom(*np.array(rows, dtype=float).reshape(-1, 6).T)


def _scan(message: Message, epoch: int) -> Scan:
    scan = decode(message.data, LASER_SCAN)
    return Scan(
        t=message.time / 1e9,
        stamp=_seconds(scan.header.stamp, epoch),
        angle_min=scan.angle_min,
        angle_increment=scan.angle_increment,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=scan.ranges,
    )


def _odometry_row(message: Message) -> tuple[float, ...]:
    odometry = decode(message.data, ODOMETRY)
    pose, twist = odometry.pose.pose, odometry.twist.twist
    q = pose.orientation
    yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
    return (
        message.time / 1e9,
        pose.position.x,
        pose.position.y,
        yaw,
        twist.linear.x,
        twist.angular.z,
    )


def _seconds(stamp: object, epoch: int) -> float:
    sec, nanosec = stamp.sec, stamp.nanosec  # type: ignore[attr-defined]
    return float(sec * 10**9 + nanosec - epoch) / 1e9
