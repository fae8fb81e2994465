"""What a node does all the time: bursts of commands, early and late ones, two for each scan.

And which callback keeps the others waiting, as its host noted it.

What is said was seen; what may lie behind it is asked.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from grader.course.exercises import Exercise
from grader.grading.causes.cause import ByName, Cause, Failed
from grader.recording import Recording
from rclpy_virtual_time import Note
from sim.messages import CMD_VEL_TOPIC

BURST = 20  # commands at one moment: no timer does that
SILENT = ("one_command_per_scan", "silent_until_ready")  # nothing before the first message
ONCE = "one_command_per_scan"
FULL = 12  # readings; a memory of ten is full
LATE = 0.005  # [s]
EVERY = re.compile(r"\bevery (\d+) ms")  # what a check of a rate expects


def kept_waiting(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return which callback waits for good, or takes as long as the commands are late."""
    recording = trials.get(failed[0].scenario or "")
    every = EVERY.search(failed[0].expected)
    for note in recording.notes if recording is not None else ():
        since, lasted = note.time / 1e9, note.lasted / 1e9
        file, _, line = note.line.rpartition(", ")
        where = f"{line} of {file}, in {note.about}"
        if note.kind == "waits":
            text = (
                f"{note.about}, called at {since:.2f} s, waits in vain to the end. Is a lock kept "
                "by an early `return`, or does it wait for something that only another callback "
                "could bring?"
            )
            return Cause.of(exercise, text, failed, where=where, replaces_help=True, own_hint=False)
        late = every is not None and lasted > float(every[1]) / 1000
        if late and note.kind == "lasts" and "timer" in note.more:
            text = f"{note.about} takes {lasted:.2f} s, as at {since:.2f} s, and " + (
                "its timer can't call it again before that is over. Don't sleep or wait in it: "
                "take what is there."
                if note.more == Note.OWN_TIMER
                else f"meanwhile {note.more} can't be called. Callbacks run side by side if they "
                "are of different callback groups, and the executor that spins the node has two "
                "threads."
            )
            return Cause.of(exercise, text, failed, where=where, replaces_help=True, own_hint=False)
    return None


def cause_of_rhythm(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return a habit of the node's whole run that explains the first failure."""
    recording = trials.get(failed[0].scenario or "")
    if recording is None or not recording.outcome.completed:
        return None
    if text := _burst(recording):
        return Cause.of(exercise, text, failed, replaces_help=True)
    if failed[0].id in SILENT and (text := _at_start(recording)):
        return Cause.of(exercise, text, failed[:1])
    if failed[0].id == ONCE and (text := _not_once(recording)):
        return Cause.of(exercise, text, failed[:1])
    return None


def _burst(recording: Recording) -> str:
    """Many commands at the very same moment: in virtual time, within one callback or many."""
    times = recording.times(CMD_VEL_TOPIC)
    if not len(times):
        return ""
    moments, counts = np.unique(np.round(times, 6), return_counts=True)
    most = int(counts.argmax())
    if recording.live is not None or counts[most] < BURST:
        return ""
    return (
        f"the node publishes {counts[most]} commands at one moment, {moments[most]:.2f} s. Does a "
        "loop in a callback go on, though the message that it looks at never changes, or is a "
        "timer made with each message? Publish once and return; the next message calls the "
        "callback again."
    )


def _at_start(recording: Recording) -> str:
    """One command before the first message."""
    first = min((m.time for m in recording.delivered), default=0)
    early = [m for m in recording.published if m.topic == CMD_VEL_TOPIC and m.time < first]
    if len(early) != 1 or early[0].time or recording.live is not None:
        return ""
    return (
        "the node publishes a command while it starts, before any message has come. Is there a "
        "publish() in the constructor?"
    )


def _not_once(recording: Recording) -> str:
    """Twice for each scan, or by a timer of its own."""
    times = np.round(recording.times(CMD_VEL_TOPIC), 6)
    scans = np.round([scan.t for scan in recording.scans()], 6)
    if recording.live is not None or len(scans) < FULL or not len(times):
        return ""
    late = float(times[0] - scans[0])
    if late > LATE and not recording.inferences and len(times) <= len(scans):
        more = int((scans <= times[0]).sum()) - 1
        return (
            f"the first command comes {late:.2f} s after the first scan, when {more} more "
            f"{'has' if more == 1 else 'have'} come. Does the callback sleep, wait or spin, does "
            "it return before its publish(), or does a timer or a thread publish instead? Publish "
            "once in the callback of /scan, and let it return at once."
        )
    if len(times) < FULL:
        return ""
    if not np.isin(times, scans).any():
        step = float(np.median(np.diff(times)))
        return (
            f"no command comes with a scan: one comes every {step:.3f} s. Does a timer or a thread "
            "publish? Publish in the callback of /scan."
        )
    moments, counts = np.unique(times, return_counts=True)
    if np.array_equal(moments, scans) and (counts == 2).all():
        return "the node publishes two commands for each scan: is there a second publish()?"
    return ""
