"""The words of the checks about a node that drives as a model says.

    predicts    the command is what the model says, clipped
    stands      0.0 for every scan, and an error in the log
    loads_once  one load, before the first scan

What is right stands in `model_cases`.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from grader.checks.ahead import front_distance
from grader.checks.case import Case, Runs
from grader.checks.commands import ZERO, Answer, spell
from grader.checks.inferences import loads, questions
from grader.checks.model_cases import CALLED, PREDICT
from grader.checks.moments import first_asked
from grader.checks.predictions import SpeedInterval, max_speed, model_file
from grader.checks.verdict import fail
from grader.checks.words import TOLERANCE, follows, logs
from grader.models.features import possible_features
from grader.recording import Recording, Scan

ERRORS = ("error", "fatal")
SILENTLY = "A robot that silently stands still costs an afternoon: log which file is the cause."
FREE = 1.2  # [m] ahead
HALF_A_CENTIMETRE = 0.005 + 1e-9  # [m/s] what rounding to two decimals changes at most


def predicts(runs: Runs, *tags: str, help: str = "", tolerance: float = TOLERANCE) -> None:
    """Fail unless the node commands what its model says, clipped, on each occasion of these tags.

    What it commands may be off by `tolerance` [m/s]. Each tag has to occur in each run.
    """
    for recording in runs:
        run = runs.of([recording])
        explain = partial(_explain, recording)
        follows(run, *tags, help=help, tolerance=tolerance, explain=explain)


def stands(runs: Runs, help: str = "A broken file can raise any exception.") -> None:
    """Fail unless the node commands 0.0 for every scan, as without a model, and logs an error."""
    follows(runs, help=help)
    for recording in runs:
        file = model_file(recording.scenario)
        logs(recording, ERRORS, what=f"there is no model to load from {file}", help=SILENTLY)


def loads_once(runs: Runs) -> None:
    """Fail unless the judge's model was loaded once, before the first scan came."""
    for recording in runs:
        times = [load.asked / 1e9 for load in loads(recording)]
        first = float(recording.times("/scan").min(initial=recording.duration_s))
        late = [t for t in times if t >= first]
        if len(times) == 1 and not late:
            continue
        fail(
            f"the model was loaded at {late[0]:.2f} s, when scans had come"
            if late
            else f"the model was loaded {len(times)} times before the first scan",
            expected="1 load, while the node is constructed",
            actual=f"{len(times)} loads",
            at=(late or [first])[0],
            recording=recording,
            help="Load in __init__, keep the model in an attribute, and use that one in the "
            "callback, also after it has raised.",
        )


def is_free(scan: Scan) -> bool:
    """Return whether the way is so free that every model trained on the course's data drives."""
    distance = front_distance(scan)
    return distance is not None and distance >= FREE


def _explain(recording: Recording, case: Case) -> str:
    """Return what else is known of a wrong command: an error in the log, no question, rounding."""
    times = recording.times("/scan")
    first, later = times.min(initial=math.inf), times[times > case.at].min(initial=math.inf)
    for line in reversed(recording.log):
        if line.level in ERRORS and (case.at <= line.t < later or line.t < first):
            return f"The node's log says: {line.text.strip()[:300]}"
    if case.said.get(PREDICT, CALLED) != CALLED:
        return "Ask the model about the features of each scan, and publish what it says."
    if not case.wrong(HALF_A_CENTIMETRE):
        return "Is something rounded, filtered or averaged? Publish what predict returns, clipped."
    return ""


def require_speed(
    recording: Recording,
    answer: Answer,
    right: SpeedInterval,
    tolerance: float,
    *,
    what: str,
    help: str,
) -> None:
    """Fail unless the command in force after this scan has the right linear.x, ± tolerance [m/s].

    `what` is the scan in words.
    """
    if answer.speed is None:
        fail(
            f"there was still no command after {what}",
            expected=f"a Twist with linear.x = {right} m/s",
            actual="nothing on /cmd_vel",
            at=answer.scan.t,
            recording=recording,
            help="Publish once at the end of the scan callback, whatever the scan was: a return "
            "before the publish() leaves the last command in force.",
        )
    if not right.allows(answer.speed, tolerance):
        fail(
            f"{what}: wrong speed",
            expected=f"linear.x = {right} m/s",
            actual=f"linear.x = {spell(answer.speed)} m/s",
            at=answer.scan.t,
            recording=recording,
            help=help,
        )


def require_asked(
    recording: Recording, scan: Scan, end: float, speed: float, tolerance: float, *, what: str
) -> None:
    """Fail unless the model was asked about a scan by `end` [s] and said this speed [m/s].

    What it said may be clipped. No question is due about a scan that may count as blind.
    """
    if np.isnan(possible_features(scan)).any():
        return
    asked = questions(recording, "predict", scan.t, end)
    limit = max_speed(recording.scenario)
    said = [min(max(s, 0.0), limit) for i in asked for s in i.said if math.isfinite(s)]
    if asked and (abs(speed) < ZERO or any(abs(s - speed) <= tolerance for s in said)):
        return
    near = any(abs(s - speed) <= HALF_A_CENTIMETRE for s in said)
    fail(
        f"{what}: the speed is near what the model said, and not equal to it"
        if near
        else f"{what}: the speed does not come from the model",
        expected="a call of predict for each scan, and what it returned, clipped",
        actual=f"linear.x = {speed:.4f} m/s; "
        + (f"the model said {', '.join(f'{s:.4f}' for s in said)}" if said else "nobody asked it"),
        at=scan.t,
        recording=recording,
        help="Is something rounded, filtered or averaged? Publish what predict returns, clipped."
        if near
        else "Ask the model about the features of each scan, and publish what it says.",
    )


def require_error_log(recording: Recording, problem: str) -> None:
    """Fail with this problem unless the node logged an error."""
    if any(line.level in ("error", "fatal") for line in recording.log):
        return
    levels = ", ".join(sorted({line.level for line in recording.log}))
    fail(
        problem,
        expected="an error in the log: self.get_logger().error(…)",
        actual=f"lines of level {levels} only" if levels else "an empty log",
        at=first_asked(recording),
        recording=recording,
        help="A robot that silently stands still costs an afternoon: log which file is the cause.",
    )
