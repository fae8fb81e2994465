"""What a node does all the time: bursts of commands, late ones, silence, everything stale.

What is said was seen; what may lie behind it is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from grader.checks.reading import published
from grader.course.exercises import Exercise
from grader.grading.causes.cause import ByName, Cause, Failed, Place, hint_at
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC

BURST = 20  # commands at one moment: no timer does that
SILENT = ("one_command_per_scan", "silent_until_ready")  # nothing before the first message
ONCE = "one_command_per_scan"
STALE = "stale_"  # begins the reasons of exercise 7 for what is too old
SETTLED = 0.6  # [s] after the start
FULL = 12  # readings; a memory of ten is full
ZERO = 1e-6  # [m/s]
LOST = 5.0  # [s] without a command, of 30
LATE = 0.005  # [s]
LONG = 100_000_000  # [ns] of a model: two periods of the control loop


def cause_of_habit(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return what the node does all the time, if that explains the first failure."""
    recording = trials.get(failed[0].scenario or "")
    if recording is None or not recording.outcome.completed:
        return None
    if text := _burst(recording):
        return Cause.of(exercise, text, failed, all_of_it=True)
    if failed[0].id in SILENT and (text := _at_start(recording)):
        return Cause.of(exercise, text, failed[:1])
    if failed[0].id == ONCE and (text := _not_once(recording)):
        return Cause.of(exercise, text, failed[:1])
    if exercise.slug not in LOOKS:
        return None
    look, place = LOOKS[exercise.slug]
    text, hint = look(trials), hint_at(exercise, place)
    return Cause.of(exercise, text, failed, hint=hint, all_of_it=True) if text else None


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
    """One command before anything came."""
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


def _always_stale(trials: ByName) -> str:
    """A node that finds everything too old, though it comes all the time."""
    recording = trials.get("safe_pass")
    if recording is None:
        return ""
    texts = [
        str(value.status[0].message)
        for time, value in published(
            recording, "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"
        )
        if time > SETTLED and value.status
    ]
    if not texts or not all(text.startswith(STALE) for text in texts):
        return ""
    reason = texts[0].split()[0].rstrip(":")
    return (
        f"all {len(texts)} reports of safe_pass after {SETTLED} s begin with {STALE} ({reason} at "
        "first), though messages keep coming. Are ages in seconds? A Duration counts nanoseconds "
        "(divide by 1e9). And is each arrival kept, by the clock that it is compared with?"
    )


def _never_ten(trials: ByName) -> str:
    """A memory that never has ten readings."""
    recording = trials.get("trend_approach")
    if recording is None or len(recording.scans()) < FULL or not len(recording.twists().t):
        return ""
    if len(recording.of("/closing_speed")):
        return ""
    return (
        f"not one closing speed comes in the {len(recording.scans())} scans of trend_approach. "
        "Does the node wait for more than ten readings, which a memory of ten never has? Is its "
        "memory emptied again and again, as the stamp is not in seconds, sec + nanosec * 1e-9?"
    )


def _waits_or_never_uses(trials: ByName) -> str:
    return _stops(trials) or _waits_for_the_model(trials) or _never_a_prediction(trials)


def _stops(trials: ByName) -> str:
    """The control loop ends in the middle of the run."""
    recording = trials.get("slow_leader")
    if recording is None:
        return ""
    times = recording.times(CMD_VEL_TOPIC)
    if not len(times) or recording.duration_s - times[-1] < LOST:
        return ""
    return (
        f"the control loop stops: its last command comes at {times[-1]:.2f} s, and then none for "
        f"{recording.duration_s - times[-1]:.0f} s. Does its callback wait for what never comes: a "
        "lock that nobody gives back (`with self.lock:` does), an empty queue, a join()?"
    )


def _waits_for_the_model(trials: ByName) -> str:
    """No command comes while the model computes."""
    recording = trials.get("slow_leader")
    if recording is None:
        return ""
    times = recording.times(CMD_VEL_TOPIC)
    spans = [
        (each.asked / 1e9 + LATE, each.answered / 1e9 - LATE)
        for each in recording.inferences
        if not each.is_load and each.took > LONG and each.answered / 1e9 < recording.duration_s
    ]
    if (
        len(spans) < FULL
        or not len(times)
        or any(((times > a) & (times < b)).any() for a, b in spans)
    ):
        return ""
    return (
        f"not one command comes while the model computes, {len(spans)} times: control waits for "
        "inference. Do both run in one thread? Then they need two: callback groups of their own "
        "and a MultiThreadedExecutor, both of them, or a worker thread for the model. Or do they "
        "share a lock? Then predict first, and hold it for the assignment only."
    )


def _never_a_prediction(trials: ByName) -> str:
    """A node that stands still, though the model has answered."""
    recording = trials.get("slow_leader")
    answers = 0 if recording is None else sum(not each.is_load for each in recording.inferences)
    if recording is None or answers < FULL:
        return ""
    speeds = recording.twists().linear_x
    if not len(speeds) or np.abs(speeds).max() > ZERO:
        return ""
    return (
        f"the model answers {answers} times, and every command is zero. Does "
        "inference keep its prediction where control reads it? And is its age in seconds, from the "
        "scan's stamp to the node's clock (get_clock(), not time.time())?"
    )


LOOKS: dict[str, tuple[Callable[[ByName], str], Place]] = {
    "safety_supervisor": (_always_stale, Place(1, 2)),
    "trend_memory": (_never_ten, Place(3, 4)),
    "slow_model": (_waits_or_never_uses, Place(2, 2)),
}
