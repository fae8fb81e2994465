"""What grows in a node while it runs, as the judge counted and measured it; what its host noted.

A node that makes a publisher, a client or a timer for each message, or keeps all that it has seen,
is right for minutes and too slow after an hour. Its answers don't show that; these numbers do.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from grader.recording.costs import lidar_period
from grader.recording.recording import Endpoint, Recording
from grader.recording.views import Floats, percentile
from grader.recording.words import told_lines
from rclpy_virtual_time import Note

PARTS, MIN_MESSAGES = 5, 40  # of a trial, and messages in each part
TIMES, RISE = 2.0, 0.001  # [s] so much more in the last part is no noise of the machine
STEADY = -0.1, 0.6  # of the rise, at least and at most, from each part to the next
ENDS = 10  # of one kind on one topic; more than anybody needs
LOSES = re.compile("takes (boolean|float),")  # where another type arrives as False or 0, in silence
MANAGED = {"unconfigured": "configure", "inactive": "activate"}  # states: the way out
WAITS = "{0} waits in the state {1}: nobody calls `ros2 lifecycle set {0} {2}`, as on a robot"
GOES_ON = (
    "{} is in the state {}, and what it publishes goes out all the same: only its own on_activate "
    "and on_deactivate switch its lifecycle publishers"
)
UNDECLARED = "no node declares {}, so that has no effect; declared here: {}"
OTHERWISE = (
    "{node} did not get what was asked for: {names}; `rclpy.init(args=…)`, `parameter_overrides` "
    "or `ignore_override` keeps it from the command line"
)
FLOOD = 50.0  # lines of log a second: a robot's disk is full some day


@dataclass(frozen=True)
class Rise:
    """Computing for a message that rises from part to part of a trial."""

    first: float  # [s] in the first part (median)
    last: float  # [s] in the last part, of nine messages in ten at least
    rate: float  # [s] a second


def rise_of(times: Floats, costs: Floats) -> Rise | None:
    """Return how the cost of messages, (n,) [s] at (n,) [s], rises; None if it doesn't.

    The cheapest tenth of a part is what the node needs, whatever else the machine did meanwhile;
    it has to rise from part to part, and not at once.
    """
    if len(costs) < PARTS * MIN_MESSAGES:
        return None
    parts = np.array_split(costs, PARTS)
    low = np.array([percentile(part, 10) for part in parts])
    first, last = percentile(parts[0], 50), float(low[-1])
    risen = last - float(low[0])
    if last < TIMES * first or risen < RISE:
        return None
    shares = np.diff(low) / risen
    if shares.min() < STEADY[0] or shares.max() > STEADY[1]:
        return None
    moments = [float(part.mean()) for part in np.array_split(times, PARTS)]
    return Rise(first, last, risen / (moments[-1] - moments[0]))


def made_again(recording: Recording) -> list[tuple[Endpoint, str]]:
    """Return the ends of which the node made more than ENDS of the same, and how many of what.

    Of timers the host reports only those that are too many.
    """
    counts = Counter(recording.endpoints)
    return [
        (end, "dozens of timers" if end.kind == "timer" else f"{count} {end.kind}s of {end.topic}")
        for end, count in counts.items()
        if count > ENDS
    ]


def _said(note: Note, recording: Recording) -> str:
    """Put a note of the host's in words; empty if the note is not worth showing."""
    at, lasted, more = note.time / 1e9, note.lasted / 1e9, note.more
    place, many = f"{note.about} ({note.line})", note.count
    long = lasted > lidar_period(recording)
    match note.kind:
        case "lost":
            were = "1 message" if many == 1 else f"{many} messages"
            return (
                f"lost: {were} on {note.about}, published before anybody had found the publisher; "
                "for a program's first node that takes 0.1 s"
            )
        case "lifecycle" if more != "active" and (many or more in MANAGED):
            return (GOES_ON if many else WAITS).format(note.about, more, MANAGED.get(more))
        case "lasts" if long:
            most = f" (the longest of {many})" if many > 1 else ""
            return f"{place} took {lasted:.1f} s from {at:.2f} s on{most}; meanwhile waited: {more}"
        case "awaits" if long:
            return (
                f"{place} has awaited something for {lasted:.1f} s from {at:.2f} s on; meanwhile "
                f"there waited for its callback group: {more}"
            )
        case "stuck":
            return (
                f"{place} awaits the answer of {more} from {at:.2f} s on, but its own callback "
                "group, which has to give or to take it, does nothing until the callback is over: "
                "give the callback a group of its own, callback_group=MutuallyExclusive…()"
            )
        case "waits" if more:
            return (
                f"{place} spins in a callback to the end, from {at:.2f} s on: what it waits for is "
                "not called back before this callback is over; go on in a function given to "
                "future.add_done_callback(…)"
            )
        case "waits":
            return (
                f"{place} waits there to the end, from {at:.2f} s on: what it waits for, a lock, "
                "an event, an answer, never comes"
            )
        case "sleeps":
            return (
                f"{place} waits there to the end, from {at:.2f} s on, for a moment that did not "
                "come: time.sleep and timeouts are in seconds"
            )
        case "timer" if not recording.published and lasted > recording.duration_s:
            return (
                f"nothing was published, and a timer of {note.about} fires after {lasted:g} s for "
                "the first time: create_timer takes seconds"
            )
        case "sim_time" if not more:
            return (
                f"{note.about} has use_sim_time, and nothing publishes /clock: on a robot its time "
                "would stand at 0 and its timers never fire; here both go on"
            )
        case "params":
            return (
                f"{note.line} has parameters for {note.about}, and none for {more}, which runs "
                "here: rclpy passes over sections whose key is not the node's name"
            )
        case "threads" if many > ENDS:
            return (
                f"{place} started {many} threads in {recording.duration_s:.0f} s: one that lives, "
                "and a queue, or a timer, do the same"
            )
    return ""


def _asked_long(note: Note, recording: Recording) -> bool:
    """Return whether a callback took most of its time for the answer of a model."""
    if note.kind != "lasts":
        return False
    begin, end = note.time, note.time + note.lasted
    asked = sum(
        min(end, each.answered) - max(begin, each.asked)
        for each in recording.inferences
        if each.answered > begin and each.asked < end
    )
    return asked > note.lasted / 2


def ended_of(recording: Recording) -> list[str]:
    """Say which of several programs ended while the others went on, a sentence each."""
    return [
        f"{note.about}{f' ({note.line})' if note.line else ''} ended at {note.time / 1e9:.1f} s: "
        f"{note.more}; the other programs went on"
        for note in recording.notes
        if note.kind == "ended"
    ]


def noted_of(recording: Recording, *, models: bool = True) -> list[str]:
    """Return the host's notes on a trial, a sentence each.

    `models`: also of callbacks that took long because the scenario's model did.
    """
    told = [note for note in recording.notes if models or not _asked_long(note, recording)]
    said = [said for note in told if (said := _said(note, recording))]
    lost = [n for n in recording.notes if n.kind == "type" and LOSES.search(n.more)]
    return [*said, *(f"on {note.about} {note.more}" for note in lost), *_not_arrived(recording)]


def _not_arrived(recording: Recording) -> Iterator[str]:
    """Say which parameters that were asked for no node declared, or got otherwise."""
    found: dict[str, list[Note]] = {}  # by node
    for note in (note for note in recording.notes if note.kind == "asked" and note.more):
        if note.line:
            found.setdefault(note.line, []).append(note)
        elif recording.outcome.completed:
            missing, _, declared = note.more.partition(note.DECLARED)
            yield UNDECLARED.format(missing, declared or "nothing")
    for node, notes in found.items():
        names = ", ".join(f"{note.about} ({note.more})" for note in notes)
        yield OTHERWISE.format(names=names, node=node)


def growth_of(recording: Recording, *, models: bool = True) -> list[str]:
    """Say what grew in a trial, or was noted; see `noted_of`."""
    said = noted_of(recording, models=models)
    said += [
        f"{end.node} made {many} in {recording.duration_s:.0f} s: make one in the constructor, and "
        "keep it"
        for end, many in made_again(recording)
    ]
    compute = recording.compute
    spent = np.fmin(compute.wall, compute.cpu)
    sent = {message.time / 1e9 for message in recording.delivered}
    there = [time in sent for time in compute.time.tolist()]
    if rise := rise_of(compute.time[there], spent[there]):
        said.append(
            f"a message costs more and more: {1000 * rise.first:.1f} ms at first, "
            f"{1000 * rise.last:.1f} ms after {recording.duration_s:.0f} s. What is made or kept "
            "for each message, and never let go?"
        )
    rate = len(told_lines(recording.log)) / max(recording.duration_s, 1.0)
    if rate > FLOOD:
        said.append(
            f"the node says {rate:.0f} lines a second; "
            "get_logger().info(…, throttle_duration_sec=1.0) says one"
        )
    return said
