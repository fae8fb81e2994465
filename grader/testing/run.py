"""One drive as a test reads it: arrays over time, and the messages."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grader.drive import event_lines
from grader.errors import InputError
from grader.recording import Floats, Odom, Outcome, Recording, Scan, Twists
from grader.report.page import page_html, page_payload
from sim.messages import CMD_VEL_TOPIC, decode

LAST_LINES = 12  # of a traceback, and of the log


class Received(NamedTuple):
    """A message, and when it was sent."""

    t: float  # [s]
    message: Any  # its fields are those of the ROS message


@dataclass(frozen=True)
class Truth:
    """Where the robot really was: (n,) samples, one every 20 ms from time 0."""

    t: Floats  # [s]
    x: Floats  # [m]
    y: Floats  # [m]
    yaw: Floats  # -π … π [rad]
    v: Floats  # forward speed [m/s]
    w: Floats  # turning speed, positive to the left [rad/s]


class Run:
    """One drive of one node, from the first second to the last.

    All times are in seconds since the scenario's start.
    """

    def __init__(self, recording: Recording, file: str) -> None:
        self.recording = recording  # everything, as the course's own checks see it
        self.file = file

    def __repr__(self) -> str:
        return f"<Run of {self.title}: {self.ending}>"

    @property
    def title(self) -> str:
        """The node and its scenario."""
        return f"{self.file} in {self.recording.name}, seed {self.recording.seed}"

    @property
    def outcome(self) -> Outcome:
        """How the program ended: `completed`, `kind`, `text`, `at` [s], `detail` (a traceback)."""
        return self.recording.outcome

    @property
    def ending(self) -> str:
        """The outcome in one line."""
        outcome = self.outcome
        if outcome.completed:
            return f"the node ran to the end, {self.duration:.1f} s"
        return f"{outcome.kind.replace('_', ' ')} at {outcome.at:.1f} s: {outcome.text}"

    @property
    def duration(self) -> float:
        """The time that was simulated [s]; less than the scenario's if the node ended."""
        return self.recording.duration_s

    @cached_property
    def truth(self) -> Truth:
        """Where the robot really was."""
        truth = self.recording.truth
        return Truth(truth.t / 1e9, truth.x, truth.y, truth.yaw, truth.v, truth.w)

    @property
    def t(self) -> Floats:
        """The times of `truth`, `clearance` and `contact`, (n,) [s]."""
        return self.truth.t

    @property
    def clearance(self) -> Floats:
        """From the robot's edge to the nearest obstacle, 0 in contact, at most 10, (n,) [m]."""
        return self.recording.truth.clearance

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Whether the robot has touched anything since the sample before, (n,)."""
        return self.recording.truth.contact

    @property
    def log(self) -> list[str]:
        """What the node logged and printed, line by line."""
        return [line.text for line in self.recording.log]

    def twists(self, topic: str = CMD_VEL_TOPIC) -> Twists:
        """Return the node's Twist messages: `t`, `linear_x`, `angular_z`, `values` (n, 6)."""
        return self.recording.twists(topic)

    def scans(self) -> tuple[Scan, ...]:
        """Return the scans that the node was sent: `t`, `ranges`, `angles`, …"""
        return self.recording.scans()

    def odometry(self) -> Odom:
        """Return the odometry that the node was sent: `t`, `x`, `y`, `yaw`, `v`, `w`."""
        return self.recording.odometry()

    def messages(self, topic: str) -> list[Received]:
        """Return the messages of a topic, from the robot or from the node, decoded.

        Raises InputError: they are of a type that ROS's common interfaces do not have.
        """
        try:
            return [
                Received(message.time / 1e9, decode(message.data, message.type))
                for message in self.recording.of(topic)
            ]
        except ValueError as error:
            raise InputError(f"messages({topic!r}): {error}") from None

    def digest(self) -> str:
        """Return a fingerprint of the run: the same node in the same scenario has the same."""
        return self.recording.digest()

    def report(self, path: str | Path) -> Path:
        """Write the replay, one HTML file that needs no network; return its path."""
        path = Path(path)
        write_replays(path, [self], f"Drive of {self.file}")
        return path

    def summary(self) -> list[str]:
        """Return what happened, line by line, with the end of log and traceback."""
        lines = [self.title, *(f"  {line}" for line in event_lines(self.recording))]
        detail = self.outcome.detail.splitlines()[-LAST_LINES:]
        said = [f"{line.time / 1e9:7.3f} s  {line.text}" for line in self.recording.log]
        for heading, quoted in (("Traceback", detail), ("Log", said[-LAST_LINES:])):
            if quoted:
                lines += [f"  {heading}:", *(f"    {line}" for line in quoted)]
        return lines


def write_replays(path: Path, runs: list[Run], title: str) -> None:
    """Write the replays of some drives as one page."""
    payload = page_payload(None, [run.recording for run in runs], title)
    path.write_text(page_html(payload), "utf-8")
