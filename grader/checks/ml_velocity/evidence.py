"""The verdicts that several checks of ml_velocity share."""

from __future__ import annotations

import math

import numpy as np

from grader.checks import model_commands
from grader.checks.commands import ZERO, Answer, garbage, judged
from grader.checks.inferences import questions
from grader.checks.ml_velocity.contract import is_predicted, right_speed
from grader.checks.model_commands import LEAST_WAY, scan_in_words
from grader.checks.predictions import max_speed
from grader.checks.verdict import fail
from grader.models.features import possible_features
from grader.recording import Recording

SPEED_TOLERANCE = 2e-4  # [m/s]; at this the probes tell distances 2.5 mm apart


def require_speeds(recording: Recording, help: str = "") -> None:
    """Fail unless the node commanded the right speed after every scan, and the model said it."""
    found = judged(recording)
    for answer in found:
        model_commands.require_speed(
            recording,
            answer,
            right_speed(recording, answer.scan),
            SPEED_TOLERANCE,
            what=scan_in_words(recording, answer),
            help=_advice(answer, help),
        )
    if is_predicted(recording):
        ends = [*(answer.scan.t for answer in found[1:]), recording.duration_s]
        for answer, end in zip(found, ends, strict=True):
            _require_asked(recording, answer, end)


def _require_asked(recording: Recording, answer: Answer, end: float) -> None:
    """Fail unless the model was asked about this scan by `end` [s], and said this speed."""
    scan, speed = answer.scan, answer.speed or 0.0
    if np.isnan(possible_features(scan)).any():  # it may count as blind: there is nothing to ask
        return
    asked = questions(recording, "predict", scan.t, end)
    limit = max_speed(recording.scenario)
    said = [min(max(s, 0.0), limit) for i in asked for s in i.said if math.isfinite(s)]
    if asked and (abs(speed) < ZERO or any(abs(s - speed) <= SPEED_TOLERANCE for s in said)):
        return
    fail(
        f"{scan_in_words(recording, answer)}: the speed does not come from the model",
        expected="one call of predict for each scan, and what it returned, clipped",
        actual=f"linear.x = {speed:.4f} m/s; "
        + (f"the model said {', '.join(f'{s:.4f}' for s in said)}" if said else "nobody asked it"),
        at=scan.t,
        recording=recording,
        help="Ask the model about the features of each scan, and publish what it says.",
    )


def require_going_on(recording: Recording, after: float) -> None:
    """Fail unless the robot drove on after this time [s]."""
    truth = recording.truth
    late = truth.t >= after * 1e9
    moved = np.hypot(np.diff(truth.x[late]), np.diff(truth.y[late])).sum()
    if moved < LEAST_WAY / 2:
        fail(
            "the robot does not drive on when the way is free again",
            expected=f"driving after {after:.0f} s",
            actual=f"{moved:.2f} m driven from then on",
            at=after,
            recording=recording,
            help="Ask the model again at each scan.",
        )


def _advice(answer: Answer, help: str) -> str:
    """Return what to look at after a wrong speed."""
    speed = answer.speed or 0.0
    if math.isnan(speed) and help:  # the model itself may predict NaN, in a field of the right type
        return help
    return garbage(speed) or help
