"""What exercise 5's recordings show of a mistake: control stops, waits, or never drives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grader.checks.evidence import Evidence, Trials
from sim.messages import CMD_VEL_TOPIC

FULL = 12  # answers of the model
ZERO = 1e-6  # [m/s]
LOST = 5.0  # [s] without a command, of 30
LATE = 0.005  # [s]
LONG = 100_000_000  # [ns] of a model: two periods of the control loop


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return how control hangs on the model, if it does."""
    text = _stops(trials) or _waits_for_the_model(trials) or _never_a_prediction(trials)
    return Evidence(text, hint="2.2", explains=failed) if text else None


def _stops(trials: Trials) -> str:
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


def _waits_for_the_model(trials: Trials) -> str:
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


def _never_a_prediction(trials: Trials) -> str:
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
