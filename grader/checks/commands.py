"""What a node publishes: which Twist answers which scan, its fields, and any other message."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from grader.checks.ahead import front_distance
from grader.checks.verdict import fail
from grader.recording import Floats, Recording, Scan
from sim.messages import decode

FIELDS = ("linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z")
WATCHDOG = 0.45  # [s] without a scan, after which a zero Twist stops the robot
ZERO = 1e-6  # [m/s, rad/s] a field nearer to 0 than this is zero
LAST_MOMENT = 0.3  # [s] before the end of a run; the answer to a scan then may come after the end
MOST_SAID = 8 << 20  # [bytes] of a topic that are read: objects take ten times as much
LATEST = 0.5  # [s] from a scan to its answer, in real time, without the node's wait for a CPU


@dataclass(frozen=True)
class Answer:
    """A scan and the command in force when the next scan came."""

    scan: Scan
    label: str  # of a bench scan; empty in a closed loop, and where scans are lost
    tags: tuple[str, ...]
    count: int  # commands between this scan and the next
    twist: Mapping[str, float]  # in force [m/s, rad/s], by FIELDS; empty: there has been none yet

    @property
    def speed(self) -> float | None:
        """`linear.x` in force [m/s]; None: there has been no command yet."""
        return self.twist.get("linear.x")

    def said(self, *fields: str) -> dict[str, float]:
        """Return these fields of the command in force, as a case has them."""
        return {name: self.twist[name] for name in fields if self.twist}

    @property
    def what(self) -> str:
        """The scan in words, for a student."""
        if self.label:
            return f"“{self.label}”"
        distance = front_distance(self.scan)
        return "a scan with nothing usable ahead" if distance is None else f"{distance:.2f} m ahead"


def answers(recording: Recording) -> list[Answer]:
    """Return each scan that was sent, with the node's answer to it.

    The answers to a scan are the commands between it and the next scan; in real time, if each scan
    was answered by one command, that command, even if it came late. What stops the robot once no
    scan has come for a while is a watchdog's, and no answer.
    """
    scans, twists, bench = recording.scans(), recording.twists(), recording.scenario.bench_scans
    if recording.scenario.faults.scan_loss:  # nobody knows which scan of the bench it is
        bench = ()
    first = np.searchsorted(twists.t, [*(scan.t for scan in scans), math.inf])
    if count := answered_in_turn(recording):
        scans, first = scans[:count], np.arange(count + 1)
    zero = np.all(np.abs(twists.values) < ZERO, axis=1)
    found = []
    for i, scan in enumerate(scans):
        begin, end = int(first[i]), int(first[i + 1])
        while end > begin + 1 and zero[end - 1] and twists.t[end - 1] > scan.t + WATCHDOG:
            end -= 1
        twist = dict(zip(FIELDS, twists.values[end - 1].tolist(), strict=True)) if end else {}
        label, tags = (bench[i].label, bench[i].tags) if bench else ("", ())
        found.append(Answer(scan, label, tags, end - begin, twist))
    return found


def answered_in_turn(recording: Recording) -> int:
    """Return how many scans were answered by one command each, in real time, even if late.

    A callback that takes longer than a period answers after the next scan has come; the answers to
    the last scans may come after the end. 0 if commands don't follow scans like this, and in
    virtual time, where computing takes no time and nothing is late.
    """
    scans, commands = recording.times("/scan"), recording.twists().t
    count = len(commands)
    if recording.live is None or count > len(scans):
        return 0
    delays = commands - scans[:count]
    unanswered = scans[count:] <= recording.duration_s - LAST_MOMENT
    latest = LATEST + _waited(recording, scans[:count], commands)
    if np.any(delays < 0.0) or np.any(delays > latest) or np.any(unanswered):
        return 0
    return count


def published(recording: Recording, topic: str, type: str) -> list[tuple[float, Any]]:
    """Return time [s] and value of each message of a type that the node published on a topic.

    The bytes may be anything: what can't be read fails the check.
    """
    found, size = [], 0
    for message in recording.published:
        if message.topic != topic or message.type != type:
            continue
        try:
            if (size := size + len(message.data)) > MOST_SAID:
                raise ValueError(f"so far these are {size:,} bytes; {MOST_SAID:,} are read")
            found.append((message.time / 1e9, decode(message.data, type)))
        except ValueError as error:
            fail(
                f"a message on {topic} can't be read",
                expected=f"a {type}",
                actual=str(error)[:200],
                at=message.time / 1e9,
                recording=recording,
                help="Publish message objects, with the Python types that their fields want.",
            )
    return found


def spell(value: float) -> str:
    """Return a command's number as a student should see it, mostly with two to four decimals."""
    if 0.0 < abs(value) < 0.005:
        return f"{value:.3g}"
    if not abs(value) < 100.0:  # a stamp has 1.7e9 s
        return f"{value:.3g}" if abs(value) > 1e12 else f"{value:.{2 + (abs(value) > 1e9)}f}"
    whole, decimals = f"{value:.4f}".split(".")
    return f"{whole}.{decimals.rstrip('0').ljust(2, '0')}"


def garbage(value: float) -> str:
    """Return an explanation if a number can only be a wrongly typed field; else an empty text."""
    if math.isnan(value) or 0.0 < abs(value) < 1e-300 or 1e30 < abs(value) < math.inf:
        return (
            "This number is garbage: the field holds an int or a np.float32 where ROS wants a "
            "Python float. Write float(…) around what you assign."
        )
    return ""


def _waited(recording: Recording, begins: Floats, ends: Floats) -> Floats:
    """Return how long in all the node waited for a CPU from each begin to its end [s], (n,)."""
    turns = recording.compute.time
    total = np.concatenate(([0.0], np.cumsum(recording.compute.queued)))
    first = np.maximum(np.searchsorted(turns, begins, side="right") - 1, 0)
    return np.asarray(total[np.maximum(np.searchsorted(turns, ends), first)] - total[first])
