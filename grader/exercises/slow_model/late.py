"""Nodes whose predictions come late: `inference_rate` and `scan_age` fail, and that is enough.

The checks of what the model sees and says would fail for the same reason. So where a node is late
with the leader's scans, they ask only whether its predictions are right ones, of whatever scan.
The checks that tell a robot to stop stay as strict as the contract; and a late node, too, goes on
asking when its model has failed, and stands while it has no prediction.
"""

from __future__ import annotations

import math
from bisect import bisect_right

from grader.checks.commands import is_zero
from grader.checks.predictions import TOLERANCE, max_speed, predictions
from grader.checks.verdict import CheckFailed, fail
from grader.exercises.slow_model.asking import answered_calls, require_newest
from grader.exercises.slow_model.contract import AGE_P95, LATEST_STOP, LEAST_RATE, MAX_AGE
from grader.exercises.slow_model.evidence import (
    RATE_FIRST,
    behind,
    fail_pauses,
    holds,
    require_ages,
    require_moves,
    require_no_strays,
    require_rate,
    spell,
)
from grader.recording import Recording

FEATURES = "Front min, mean, std within ±60°, then the minimum to the left, then to the right."
LEAST_ANSWERS = 3  # from the model, of a node that uses it


def is_late(leader: Recording) -> bool:
    """Tell whether a node is late in the leader's scenario: then `scan_age` is not passed."""
    try:
        require_rate(leader, LEAST_RATE)
        require_ages(leader, AGE_P95)
        require_newest(leader)
    except CheckFailed:
        return True
    return False


def require_right_though_late(recording: Recording) -> None:
    """Fail unless the commands are predictions of scans, however old, and not all are 0.0."""
    require_moves(recording)
    require_no_strays(recording, behind(recording))
    require_goes_on(recording)
    require_stands_without(recording)


def require_goes_on(recording: Recording) -> None:
    """Fail if the model was never asked again when the last scans with a prediction had come."""
    said = predictions(recording)
    since = max((begin for *_, begin, _, n in holds(recording) if said[n].exists), default=0.0)
    asked = [i.asked / 1e9 for i in recording.inferences if i.method == "predict" and i.asked >= 0]
    if not any(at >= since for at in asked):
        fail(
            "inference ends, and does not begin again",
            expected="a call of predict for a newest scan whenever the last one has ended",
            actual=f"no call after {max(asked, default=0.0):.2f} s",
            at=since,
            recording=recording,
            help="After an exception, NaN or a blind sector the next scan is a new start.",
        )


def require_stands_without(recording: Recording) -> None:
    """Fail if the robot is told to drive long after the last answer that can be used.

    No prediction may be older than its scan, however late that was: so the age of the answer is the
    least that a command's age can be.
    """
    twists = recording.twists()
    answered = sorted(
        call.answered / 1e9 for call in answered_calls(recording) if math.isfinite(call.said[0])
    )
    for t, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        had = bisect_right(answered, t)
        if is_zero(speed) or not had or t - answered[had - 1] <= LATEST_STOP + recording.slack:
            continue
        fail(
            "the robot drives on, though the model has not predicted anything for a while",
            expected=f"0.0 when the newest prediction is more than {MAX_AGE} s old",
            actual=f"{spell(speed)}, {t - answered[had - 1]:.2f} s after the last one",
            at=t,
            recording=recording,
            help="An answer that is no number is no new prediction: keep the stamp of the last.",
        )


def require_answers(recording: Recording, least: float) -> None:
    """Fail unless the model was asked about different scans at this rate [Hz], however late."""
    require_moves(recording)
    first = recording.scans()[0].t
    said = {call.said[0] for call in answered_calls(recording)}
    rate = len(said) / (recording.duration_s - first)
    if rate < least:
        fail_pauses(recording, rate, least, first)


def require_right_answers(recording: Recording) -> None:
    """Fail unless the model was asked about scans that had come, and about nothing else."""
    said, calls = predictions(recording), answered_calls(recording)
    require_goes_on(recording)
    if len(calls) < LEAST_ANSWERS:
        fail(
            f"the model was asked {len(calls)} times, so this proves nothing",
            expected="a call of predict for a newest scan whenever the last one has ended",
            actual=f"{len(calls)} calls in {recording.duration_s:.1f} s",
            at=min(LATEST_STOP, recording.duration_s),
            recording=recording,
            help=RATE_FIRST,
        )
    for call in calls:
        asked = call.asked / 1e9
        there = [prediction for prediction in said if prediction.scan.t <= asked]
        speed = min(max(call.said[0], 0.0), max_speed(recording.scenario))
        if not any(p.least - TOLERANCE <= speed <= p.most + TOLERANCE for p in there):
            newest = there[-1].text if there else "nothing yet"
            fail(
                "the model's answer is that to no scan",
                expected=f"a scan's features; for the newest scan the model says {newest}",
                actual=spell(speed),
                at=asked,
                recording=recording,
                help=FEATURES,
            )
