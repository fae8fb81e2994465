"""What happened in one trial, frozen: the only thing that checks and reports ever see.

A recording holds every message that crossed the link, the simulator's ground truth, the node's
endpoints and log, and how the node ended. The checks' verdict depends on nothing else, so a
recording can be saved as a bag (see grader.recording.bag), loaded and judged again without running
any student's code.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import msgspec
import numpy as np

from grader.recording import views
from grader.recording.inferences import Inference
from grader.recording.training import Training
from grader.recording.views import Floats, Goals, Odom, Scan, Twists
from rclpy_virtual_time import Ended, Link, LogLine, Note
from sim.layout import Layout, layout_to_json
from sim.messages import (
    CMD_VEL_TOPIC,
    EPOCH_NS,
    GOAL_TOPIC,
    ODOM_TOPIC,
    SCAN_TOPIC,
    Message,
    canonical,
)
from sim.scenario import Scenario
from sim.sensors import OFFERED
from sim.simulation import Truth

COMPLETED = "completed"
UNEXPLAINED = 0.02  # [s] of a turn without CPU time; below it nobody measured the wait for a CPU
WELL = (("exited", "sys.exit()"), ("exited", "sys.exit(0)"), ("exited", "sys.exit(False)"))
SHUT_DOWN = (
    "Ctrl-C has shut rclpy down by then: publish only if rclpy.ok(), and call rclpy.try_shutdown()"
)


@dataclass(frozen=True)
class Outcome:
    """How the node's program ended.

    `kind` is `completed` (the scenario ran to its end with the node alive) or one of
    `missing` (a file of the submission), `unreadable`, `syntax_error`, `exception`, `returned`,
    `exited` (sys.exit), `died` (the process vanished), `hung` (no answer within the wall time),
    `slow` (answers, but not done within it), `stuck` (a deadlock), `never_spun`, `flooded`,
    `forged`, `held` (its launch file can't be read here: a person has to look), `real_time` (it
    can't run in virtual time, and has to run again).
    """

    kind: str
    text: str = ""  # one line for the student
    at: float = 0.0  # [s] since the scenario's start
    detail: str = ""  # a traceback or stacks, in full

    @property
    def completed(self) -> bool:
        """The node ran to the end."""
        return self.kind == COMPLETED

    @property
    def by_itself(self) -> bool:
        """The program came to its end without an error, before the scenario did."""
        return self.kind == "returned" or (self.kind, self.text) in WELL


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
    process: str = ""  # its program's file; of one that was started before, "guard.py (2)"

    @property
    def matched(self) -> bool:
        """Whether the endpoint can talk to the robot's on its topic (or the robot has none)."""
        return not self.mismatch


@dataclass(frozen=True)
class Compute:
    """The cost of each exchange with the host; measured by the judge, different on each machine."""

    time: Floats  # (n,) [s] scenario time at which it began
    wall: Floats  # (n,) [s]
    cpu: Floats  # (n,) [s] of the host's process; nan where the system doesn't tell
    queued: Floats  # (n,) [s] waited for a CPU, by host or judge; measured only if wall >> cpu

    @property
    def computed(self) -> Floats:
        """(n,) [s] without waits; where the system doesn't tell, without what may be one."""
        return np.where(np.isnan(self.cpu), self.wall - self.queued, np.fmin(self.wall, self.cpu))

    @property
    def busy(self) -> Floats:
        """(n,) [s] in which the node computed, or waited for anything but a CPU."""
        waited = self.wall - self.computed > UNEXPLAINED
        return np.where(waited, np.maximum(self.wall - self.queued, self.computed), self.computed)


class Live(msgspec.Struct, frozen=True):
    """What a trial in real time adds to a recording."""

    epoch: int  # [ns] since 1970 at the scenario's start
    reason: str  # why it was not in virtual time; "" if real time was asked for
    lateness: float  # [s] of the robot's latest message
    starved: float  # [s] that a thread of the node waited for a CPU, at worst
    stall: str = ""  # what the machine did that makes the recording worthless; "" if nothing


@dataclass(frozen=True)
class Ending:
    """The node's reaction to SIGINT at the end of the scenario, as on Ctrl-C.

    No check sees this. The outcome's kind is `running` if the program had not ended after a second.
    """

    outcome: Outcome
    published: tuple[Message, ...] = ()  # after the SIGINT
    log: tuple[LogLine, ...] = ()

    @property
    def problem(self) -> str:
        """The defect to repair, in one line; empty if the program ended as it should.

        Ending with a KeyboardInterrupt is what Python does.
        """
        kind, text = self.outcome.kind, self.outcome.text
        if kind == "running":
            return (
                "the program has not ended after a second: does it catch the signal and go on, "
                "does a thread of it never end, or does its end wait for something?"
            )
        if kind in ("hung", "flooded"):
            return text
        if kind != "exception" or text.startswith(Ended.ASKED_TO_END):
            return ""
        return f"{text}; {SHUT_DOWN}" if "context" in text and "RCLError" in text else text


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
    inferences: tuple[Inference, ...] = ()  # of models that the judge keeps, in order
    charged: bool = False  # computing took virtual time, so another run differs
    ending: Ending | None = None  # what Ctrl-C did after all that, if it was asked for; not saved
    notes: tuple[Note, ...] = ()  # the host's, for a person; no check sees them, and no bag
    moments: tuple[
        tuple[str, Link.Moment], ...
    ] = ()  # looked into, each with its program; not saved
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
        """Return the node's longest wait for a CPU between two moments [s].

        0 in virtual time. `slack` is the worst of the whole trial; this is the worst of one span,
        for limits that would become too generous with it.
        """
        if self.live is None:
            return 0.0
        first = max(0, int(np.searchsorted(self.compute.time, begin, side="right")) - 1)
        last = int(np.searchsorted(self.compute.time, end))
        return float(self.compute.queued[first:last].max(initial=0.0))

    @cached_property
    def ends(self) -> tuple[Endpoint, ...]:
        """The endpoints of the student's programs, whatever their nodes are called."""
        ours = {program.file for program in self.scenario.program if program.supplied}
        if not any(end.process for end in self.endpoints):  # a recording of 1.0.0
            return tuple(end for end in self.endpoints if not end.node.startswith("/course_"))
        return tuple(end for end in self.endpoints if end.process not in ours)

    @cached_property
    def messages(self) -> tuple[Message, ...]:
        """Everything that crossed the link, in order of time."""
        return tuple(sorted(self.delivered + self.published, key=lambda message: message.time))

    @cached_property
    def _by_topic(self) -> dict[str, list[Message]]:
        found: dict[str, list[Message]] = {}
        for message in self.messages:
            found.setdefault(message.topic, []).append(message)
        return found

    def of(self, topic: str) -> Sequence[Message]:
        """Return the messages of one topic, in order of time."""
        return self._by_topic.get(topic, ())

    def times(self, topic: str) -> Floats:
        """Return when the messages of a topic crossed the link, (n,) [s]."""
        return np.array([message.time for message in self.of(topic)], dtype=float) / 1e9

    def twists(self, topic: str = CMD_VEL_TOPIC) -> Twists:
        """Return the node's Twist messages; what is not a Twist is left out."""
        if topic not in self._twists:
            self._twists[topic] = views.twists(m for m in self.published if m.topic == topic)
        return self._twists[topic]

    def scans(self) -> tuple[Scan, ...]:
        """Return the scans that the node was sent."""
        return self._scans

    def odometry(self) -> Odom:
        """Return the odometry that the node was sent."""
        return self._odometry

    def goals(self) -> Goals:
        """Return the goals that the node was sent."""
        return views.goals(self._delivered(GOAL_TOPIC))

    @cached_property
    def judged(self) -> dict[Any, Any]:
        """The oracles' results for this recording, each computed once for all checks."""
        return {}

    def digest(self) -> str:
        """Return a fingerprint of all that must be the same in every run of the same node.

        The text of the log and the measured compute times are left out.
        """
        result = hashlib.sha256(layout_to_json(self.layout).encode())
        for message in (*self.delivered, *self.published):
            result.update(f"{message.time} {message.topic} {message.type}".encode())
            result.update(canonical(message.data, message.type))
        truth = self.truth
        for array in (truth.t, truth.x, truth.y, truth.yaw, truth.v, truth.w, truth.clearance):
            result.update(array.tobytes())
        result.update(truth.contact.tobytes())
        ends = [msgspec.structs.asdict(end) for end in self.endpoints]
        ends = [{name: end[name] for name in end if name != "process"} for end in ends]
        result.update(msgspec.json.encode(ends))
        if self.live is None:
            result.update(msgspec.msgpack.encode(self.inferences))
        if self.training is not None:
            for answers in (self.training.pickle, self.training.again, self.training.onnx):
                result.update(answers.values)
        result.update(f"{self.outcome.kind} {self.outcome.at:.9f} {self.seed}".encode())
        return result.hexdigest()

    # --- decoded once ----------------------------------------------------------------------------

    def _delivered(self, topic: str) -> Iterator[Message]:
        return (m for m in self.delivered if m.topic == topic and m.type == OFFERED[topic])

    @cached_property
    def _twists(self) -> dict[str, Twists]:
        return {}

    @cached_property
    def _scans(self) -> tuple[Scan, ...]:
        return views.scans(self._delivered(SCAN_TOPIC), self.epoch, self.scenario.lidar.pose[2])

    @cached_property
    def _odometry(self) -> Odom:
        return views.odometry(self._delivered(ODOM_TOPIC))
