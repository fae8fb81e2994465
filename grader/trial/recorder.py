"""The record of a trial while it grows, until it is frozen into a recording."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec
import numpy as np

from grader.recording import Compute, Endpoint, Inference, Live, Outcome, Recording
from rclpy_virtual_time import EndpointReport, Flood, HostForged, Link, LogLine, Note, Published
from sim.messages import (
    CMD_VEL_TOPIC,
    TWIST,
    TWIST_STAMPED,
    Message,
    twist_from_cdr,
    twist_stamped_from_cdr,
)
from sim.sensors import OFFERED
from sim.simulation import Simulation

MAX_BYTES = 64 * 1024 * 1024  # a node may publish in one trial
MAX_MESSAGES = 50_000  # in one trial: 800 a second in the longest scenario
MESSAGE_BYTES = 128  # what a message takes besides its data and names
MAX_ENDPOINTS = 1_000
OURS = ("/course/", "/ground_truth/", "/rosout")  # topics of our own in a bag

Command = tuple[int, float, float]  # time [ns], linear.x [m/s], angular.z [rad/s]


class Recorder:
    """What has happened in a trial so far.

    Parameters
    ----------
    stamped
        The robot takes TwistStamped as well as Twist.
    programs
        Files of the programs that run, in order.
    most
        What the node may publish [bytes].
    looks
        Moments that somebody looks into [ns].
    """

    def __init__(
        self,
        programs: Sequence[str] = (),
        *,
        stamped: bool = False,
        most: int = MAX_BYTES,
        looks: Sequence[int] = (),
    ) -> None:
        again = [programs[:i].count(file) for i, file in enumerate(programs)]
        named = zip(programs, again, strict=True)
        self._processes = [f"{file} ({n + 1})" if n else file for file, n in named]
        self.delivered: list[Message] = []
        self.published: list[Message] = []
        self.endpoints: list[Endpoint] = []
        self.compute: list[tuple[float, float, float, float]] = []
        self._notes: dict[tuple[str, str, str], Note] = {}
        self._moments: dict[tuple[int, int, str, str], Link.Moment] = {}
        self._stamped, self._most, self._looks = stamped, most, looks
        self._bytes = 0

    def note_endpoints(self, reports: Iterable[EndpointReport]) -> None:
        """Note the endpoints that the node has created."""
        names = dict(enumerate(self._processes))
        for report in reports:
            if report.process not in names and names:
                raise HostForged(f"an end of program {report.process}")
            end = Endpoint(*msgspec.structs.astuple(report))
            of = names.get(report.process, "")
            self.endpoints.append(msgspec.structs.replace(end, process=of))
        if len(self.endpoints) > MAX_ENDPOINTS:
            raise Flood(f"more than {MAX_ENDPOINTS} endpoints")

    def note(self, notes: Iterable[Note]) -> None:
        """Keep notes for a person, the latest of each kind."""
        for note in notes:
            key = (note.kind, note.about, note.line)
            if key in self._notes or len(self._notes) < Note.MOST:
                self._notes[key] = note

    def look(self, moments: Iterable[Link.Moment]) -> None:
        """Keep what is told of moments, the latest of each.

        Raises HostForged: nobody has asked, or there is no such program.
        """
        most = Link.Moment.FUNCTIONS * len(self._looks) * len(self._processes)
        for moment in moments:
            if moment.asked not in self._looks or moment.program >= len(self._processes):
                raise HostForged(f"moment {moment.asked} of program {moment.program}")
            key = moment.asked, moment.program, moment.place.function, moment.place.line
            if key in self._moments or len(self._moments) < most:
                self._moments[key] = moment

    def hear(self, heard: Iterable[Published], began: int, reached: int) -> list[Command]:
        """Note messages of the node, sent between two times [ns]; return its commands.

        Raises HostForged: a message's time is impossible.
        Raises Flood: there are too many.
        """
        commands = []
        for published in heard:
            message = self._message(published, began, reached)
            self.published.append(message)
            command = _command(message, self._stamped)
            if command is not None:
                commands.append(command)
        return commands

    def freeze(
        self,
        simulation: Simulation,
        outcome: Outcome,
        log: Iterable[LogLine] = (),
        live: Live | None = None,
        asked: Iterable[Inference] = (),
        *,
        truncated: bool = False,
        charged: bool = False,
    ) -> Recording:
        """Return the recording of a trial that is over, with what the robot did in it."""
        ours = {spec.file for spec in simulation.scenario.program if spec.supplied}
        compute = np.array(self.compute, dtype=float).reshape(-1, 4).T
        return Recording(
            scenario=simulation.scenario,
            layout=simulation.layout,
            seed=simulation.seed,
            duration_s=simulation.now / 1e9,
            delivered=tuple(self.delivered),
            published=tuple(self.published),
            truth=simulation.truth(),
            outcome=outcome,
            endpoints=tuple(self.endpoints),
            log=tuple(log),
            log_truncated=truncated,
            compute=Compute(*compute),
            live=live,
            inferences=tuple(asked),
            charged=charged,
            moments=tuple(
                (file, self._moments[key])
                for key in sorted(self._moments, key=lambda key: key[:2])  # the last told is last
                if (file := self._processes[key[1]]).partition(" (")[0] not in ours
            ),
            notes=tuple(
                note
                for note in self._notes.values()
                if _holds(note, outcome.at) and note.line.partition(", ")[0] not in ours
            ),
        )

    def _message(self, published: Published, began: int, reached: int) -> Message:
        if not began <= published.time <= reached:
            raise HostForged(f"a message at {published.time}, between {began} and {reached}")
        if self.published and published.time < self.published[-1].time:
            raise HostForged("messages that go back in time")
        if len(self.published) >= MAX_MESSAGES:
            raise Flood(f"more than {MAX_MESSAGES:,} messages")
        names = len(published.topic) + len(published.type)
        self._bytes += len(published.data) + names + MESSAGE_BYTES
        if self._bytes > self._most:
            raise Flood(f"more than {self._most:,} bytes of messages")
        topic = published.topic
        if topic in OFFERED or topic.startswith(OURS):  # a node that speaks in the robot's name
            topic = f"/from_node{topic}"
        return Message(topic, published.type, published.time, published.data)


def _holds(note: Note, end: float) -> bool:
    """Return whether a note is true at the end [s]: a callback that waited may have come back."""
    return note.kind not in ("waits", "sleeps") or (note.time + note.lasted) / 1e9 > end - 1e-6


def _command(message: Message, stamped: bool) -> Command | None:
    """Return the command for the robot's motors in a message, if it has one."""
    if message.topic != CMD_VEL_TOPIC:
        return None
    try:
        if message.type == TWIST:
            linear_x, _, _, _, _, angular_z = twist_from_cdr(message.data)
        elif stamped and message.type == TWIST_STAMPED:
            linear_x, _, _, _, _, angular_z = twist_stamped_from_cdr(message.data)
        else:
            return None
    except ValueError:
        return None
    return message.time, linear_x, angular_z
