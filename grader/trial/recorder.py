"""The growing record of a trial, until it is frozen into a recording."""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from grader.host.frames import EndpointReport, Published
from grader.link.link import HostForged, Output
from grader.link.log import LogLine
from grader.recording import Compute, Endpoint, Live, Outcome, Recording
from sim.messages import (
    CMD_VEL_TOPIC,
    OFFERED,
    TWIST,
    TWIST_STAMPED,
    Message,
    twist_from_cdr,
    twist_stamped_from_cdr,
)
from sim.simulation import Simulation

MAX_BYTES = 64 * 1024 * 1024  # a node may publish in one trial
MESSAGE_BYTES = 128  # what a message takes besides its data and names
MAX_ENDPOINTS = 1_000
MAX_FOLDER = 256 * 1024 * 1024  # [bytes] that a node may leave in its folder
MAX_FILES = 5_000
AFTERMATH_NS = 10**9  # the robot rolls on for this long when its node is gone
OURS = ("/course/", "/ground_truth/", "/rosout")  # topics of our own in a bag

Command = tuple[int, float, float]  # time [ns], linear.x [m/s], angular.z [rad/s]


class Flood(Exception):
    """The node published too much."""


class Recorder:
    """What a trial has given so far.

    Parameters
    ----------
    stamped
        The robot takes TwistStamped as well as Twist.
    """

    def __init__(self, simulation: Simulation, *, stamped: bool = False) -> None:
        self.simulation = simulation
        self.end = round(simulation.scenario.duration * 1e9)  # [ns]
        self.delivered: list[Message] = []
        self.published: list[Message] = []
        self.endpoints: list[Endpoint] = []
        self.compute: list[tuple[float, float, float, float]] = []
        self._stamped = stamped
        self._bytes = 0

    def note_endpoints(self, reports: Iterable[EndpointReport]) -> None:
        """Note what the node has created."""
        self.endpoints += [_endpoint(report) for report in reports]
        if len(self.endpoints) > MAX_ENDPOINTS:
            raise Flood(f"more than {MAX_ENDPOINTS} endpoints")

    def hear(self, heard: Iterable[Published], began: int, reached: int) -> list[Command]:
        """Note messages of the node, sent between two times [ns]; return its commands.

        Raises
        ------
        HostForged
            A message's time is impossible.
        Flood
            There are too many.
        """
        commands = []
        for published in heard:
            message = self._message(published, began, reached)
            self.published.append(message)
            command = _command(message, self._stamped)
            if command is not None:
                commands.append(command)
        return commands

    def check_folder(self, folder: Path) -> None:
        """Make sure that the node doesn't fill the disk."""
        size = 0
        for count, entry in enumerate(_entries(folder), start=1):
            with contextlib.suppress(OSError):
                size += entry.stat(follow_symlinks=False).st_size
            if size > MAX_FOLDER or count > MAX_FILES:
                raise Flood(f"more than {MAX_FILES:,} files or {MAX_FOLDER:,} bytes in its folder")

    def roll_on(self, reached: int, commands: Sequence[Command]) -> None:
        """Let the robot roll on for a while after its node has ended."""
        until = max(self.simulation.now, min(reached + AFTERMATH_NS, self.end))
        self.simulation.advance(until, commands)

    def freeze(
        self,
        outcome: Outcome,
        folder: Path,
        log: Iterable[LogLine],
        output: Iterable[Output],
        live: Live | None = None,
    ) -> Recording:
        """Return the recording; paths in `folder` are shown as the student knows them."""
        compute = np.array(self.compute, dtype=float).reshape(-1, 4).T
        return Recording(
            scenario=self.simulation.scenario,
            layout=self.simulation.layout,
            seed=self.simulation.seed,
            duration_s=self.simulation.now / 1e9,
            delivered=tuple(self.delivered),
            published=tuple(self.published),
            truth=self.simulation.truth(),
            outcome=without_folder(outcome, folder),
            endpoints=tuple(self.endpoints),
            log=tuple(line_without_folder(line, folder) for line in log),
            log_truncated=any(stream.truncated for stream in output),
            compute=Compute(*compute),
            live=live,
        )

    def _message(self, published: Published, began: int, reached: int) -> Message:
        if not began <= published.time <= reached:
            raise HostForged(f"a message at {published.time}, between {began} and {reached}")
        if self.published and published.time < self.published[-1].time:
            raise HostForged("messages that go back in time")
        names = len(published.topic) + len(published.type)
        self._bytes += len(published.data) + names + MESSAGE_BYTES
        if self._bytes > MAX_BYTES:
            raise Flood(f"more than {MAX_BYTES:,} bytes of messages")
        topic = published.topic
        if topic in OFFERED or topic.startswith(OURS):  # a node that speaks in the robot's name
            topic = f"/from_node{topic}"
        return Message(topic, published.type, published.time, published.data)


def _command(message: Message, stamped: bool) -> Command | None:
    """Return what the robot's motors make of a message, if it is for them."""
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


def _endpoint(report: EndpointReport) -> Endpoint:
    return Endpoint(
        report.kind,
        report.node,
        report.topic,
        report.type,
        report.reliability,
        report.durability,
        report.depth,
        report.mismatch,
    )


def _entries(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Return what lies in a folder; without recursion, because it may be deep.

    Raises
    ------
    Flood
        It is deeper than a path may be long: what lies there can't be counted.
    """
    pending = [str(folder)]
    while pending:
        try:
            with os.scandir(pending.pop()) as entries:
                found = list(itertools.islice(entries, MAX_FILES + 1))
        except OSError as error:
            if error.errno == errno.ENAMETOOLONG:
                raise Flood("folders in one another without end") from None
            continue  # gone, or closed to the judge: then nobody else can use it either
        yield from found
        pending += [entry.path for entry in found if entry.is_dir(follow_symlinks=False)]


def without_folder(outcome: Outcome, folder: Path) -> Outcome:
    """Show paths as the student knows them: the copy's folder changes from run to run."""
    prefix = f"{folder}/"
    return Outcome(
        outcome.kind,
        outcome.text.replace(prefix, ""),
        outcome.at,
        outcome.detail.replace(prefix, ""),
    )


def line_without_folder(line: LogLine, folder: Path) -> LogLine:
    """Show paths as the student knows them."""
    return LogLine(line.time, line.level, line.text.replace(f"{folder}/", ""))


def not_run(simulation: Simulation, outcome: Outcome) -> Recording:
    """Return the recording of a scenario in which no node ran."""
    return Recorder(simulation).freeze(outcome, Path(), (), ())
