"""What exercise 5's recordings show of a mistake: the control loop stops, or waits."""

from __future__ import annotations

from collections.abc import Sequence

from grader.checks.verdict import Evidence, Trials
from sim.messages import CMD_VEL_TOPIC

FULL = 12  # answers of the model
LOST = 5.0  # [s] without a command, of 30
LATE = 0.005  # [s]
LONG = 100_000_000  # [ns] of a model: two periods of the control loop


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return how control hangs on the model, if it does."""
    recording = trials.get("slow_leader")
    if recording is None or not len(times := recording.times(CMD_VEL_TOPIC)):
        return None
    if recording.duration_s - times[-1] >= LOST:
        text = (
            f"the control loop stops: its last command comes at {times[-1]:.2f} s. Does its "
            "callback wait for what never comes: a lock that nobody gives back (`with self.lock:` "
            "does), an empty queue, a join()?"
        )
        return Evidence(text, hint="2.2", explains=failed)
    spans = [
        (each.asked / 1e9 + LATE, each.answered / 1e9 - LATE)
        for each in recording.inferences
        if not each.is_load and each.took > LONG and each.answered / 1e9 < recording.duration_s
    ]
    if len(spans) < FULL or any(((times > a) & (times < b)).any() for a, b in spans):
        return None
    text = (
        f"not one command comes while the model computes, {len(spans)} times: control waits for "
        "inference. Do both run in one thread? Then they need two: callback groups of their own "
        "and a MultiThreadedExecutor, both of them, or a worker thread for the model. Or do they "
        "share a lock? Then predict first, and hold it for the assignment only."
    )
    return Evidence(text, hint="2.2", explains=failed)
