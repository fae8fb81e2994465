"""What the model is asked about each scan, and what becomes of its answer."""

from __future__ import annotations

import math
from dataclasses import replace

from grader.checks.case import Runs
from grader.checks.predictions import PREDICT, questions
from grader.checks.verbs import require_allowed
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.recording import Recording

MEASURE = (
    "Call predict for each scan, and measure that call: numbers about no calls, or about others, "
    "say nothing about the model that drives."
)


def answers_all(recording: Recording) -> None:
    """Fail if fewer commands came than scans, though some of these came during a long call."""
    require_alive(recording)
    scans, commands = len(recording.scans()), len(recording.twists().t)
    if commands < scans:
        fail(
            f"{commands} commands followed {scans} scans",
            at=recording.scans()[-1].t,
            recording=recording,
            help="Some of the scans came while predict still ran. A subscription keeps as many as "
            "its depth says, 5 with qos_profile_sensor_data; each wants a Twist.",
        )


def asks_once_each(runs: Runs) -> None:
    """Fail unless the model was asked about each scan that has features, and once.

    What is measured is up to the node: numbers about no calls, or always the same ones, are right
    and say nothing.
    """
    for recording, case in runs.cases():
        if asked := case.allowed.get(PREDICT):
            about = replace(case, allowed={PREDICT: asked})
            require_allowed(recording, about, MEASURE, topic=PREDICT)
    for recording in runs:
        require_alive(recording)
        scans = recording.times("/scan")
        first = float(scans[0]) if len(scans) else 0.0  # it may warm up before
        calls = questions(recording, PREDICT, first, math.inf)
        for number, at in enumerate(sorted(call.asked / 1e9 for call in calls), 1):
            if number > (scans <= at + recording.slack).sum():
                fail(
                    f"call {number} of predict came before as many scans had come",
                    expected="one call of predict for each scan that has features",
                    at=at,
                    recording=recording,
                    help="Also after NaN or an exception: 0.0 for this scan; the next is asked.",
                )
