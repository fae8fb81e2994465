"""What the model is asked about each scan, and what becomes of its answer."""

from __future__ import annotations

import math
from dataclasses import replace

from grader.checks.case import Runs, spell_allowed
from grader.checks.inferences import questions
from grader.checks.predictions import TOLERANCE, Prediction, max_speed, predictions
from grader.checks.turns import turns
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import require_allowed
from grader.recording import Inference, Recording

LATEST_CALL = 0.5  # [s] from a scan to its call of predict
LATE_IN_REAL_TIME = 0.1  # of the scans, whose calls may come later on a busy machine


def predicts_late(runs: Runs, tag: str, help: str) -> None:
    """Fail unless the prediction for a scan with this tag is among the commands after it.

    Other scans have waited for it, and the commands for all of them come at the same moment.
    """
    for recording, case in runs.cases(tag):
        twists, allowed = recording.twists(), {"linear.x": case.allowed["linear.x"]}
        after = twists.linear_x[twists.t > case.at].tolist()
        said = [replace(case, allowed=allowed, said={"linear.x": speed}) for speed in after]
        if all(each.wrong(TOLERANCE) for each in said):
            require_allowed(recording, said[0] if said else replace(case, said={}), help)


def answers_all(recording: Recording) -> None:
    """Fail if fewer commands came than scans, though some of these came during a long call."""
    require_alive(recording)
    scans, commands = len(recording.scans()), len(recording.twists().t)
    if commands < scans:
        fail(
            f"{commands} commands followed {scans} scans",
            expected=f"{scans}: a Twist for each scan",
            actual=f"{commands}",
            at=recording.scans()[-1].t,
            recording=recording,
            help="Some of the scans came while predict still ran. A subscription keeps as many as "
            "its depth says, 5 with qos_profile_sensor_data; each wants a Twist.",
        )


def asks_once_each(runs: Runs) -> None:
    """Fail unless the model was asked about each scan that has features: once, with one row.

    What is measured is up to the node: numbers about no calls, or always the same ones, are right
    and say nothing.
    """
    for recording in runs:
        require_alive(recording)
        scans = [scan.t for scan in recording.scans()]
        calls = questions(recording, "predict", scans[0], math.inf)  # it may warm up before
        calls = sorted(calls, key=lambda call: call.asked)
        _require_no_second_call(recording, calls, scans)
        _require_a_call_each(recording, calls)


def _require_no_second_call(
    recording: Recording, calls: list[Inference], scans: list[float]
) -> None:
    for number, at in enumerate((call.asked / 1e9 for call in calls), 1):
        come = sum(scan <= at + recording.slack for scan in scans)
        if number > come:
            fail(
                f"predict was called again for the scan at {scans[come - 1]:.2f} s",
                expected="one call of predict for each scan that has features",
                actual=f"call {number} at {at:.3f} s, though only {come} scans had come",
                at=at,
                recording=recording,
                help="Also after NaN or an exception: 0.0 for this scan, and the next is asked.",
            )


def _require_a_call_each(recording: Recording, calls: list[Inference]) -> None:
    said = predictions(recording)[: len(turns(recording)[0])]
    missed, place = [], 0
    for right in said:
        if right.missing:  # blind, or the model says nothing: only the node can know that
            continue
        left = range(place, len(calls))
        found = next((i for i in left if _is_about(recording, calls[i], right)), None)
        if found is None:
            missed.append(right)
        else:
            place = found + 1
    if len(missed) > (LATE_IN_REAL_TIME * len(said) if recording.live is not None else 0):
        fail(
            f"the model was not asked about the scan at {missed[0].scan.t:.2f} s",
            expected=f"one call of predict, with one row, that returns "
            f"{spell_allowed(missed[0].allowed, 'm/s')}",
            actual=f"{len(calls)} calls in all; {len(missed)} of {len(said)} scans without one",
            at=missed[0].scan.t,
            recording=recording,
            help="Call predict for each scan, and measure that call: numbers about no calls, or "
            "about others, say nothing about the model that drives.",
        )


def _is_about(recording: Recording, call: Inference, right: Prediction) -> bool:
    """Return whether a call came soon after this scan, had one row, and said what is right."""
    delay, limit = call.asked / 1e9 - right.scan.t, max_speed(recording.scenario)
    soon = -recording.slack <= delay <= LATEST_CALL + recording.slack
    return soon and len(call.said) == 1 and right.allows(max(0.0, min(limit, call.said[0])))
