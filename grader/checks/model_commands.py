"""Whether a node commands what its model predicts: verdicts that exercises 2, 8 and 9 share."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from grader.checks.commands import ZERO, Answer, spell
from grader.checks.driving import path_length, require_no_contact
from grader.checks.inferences import questions
from grader.checks.moments import came_to_rest, first_asked
from grader.checks.predictions import MAX_SPEED, SpeedInterval, max_speed
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.models.features import possible_features
from grader.recording import Recording, Scan

LEAST_WAY = 0.8  # [m]
BRISK = 0.5  # of max_speed; worlds differ, and the models drive slowly where it is narrow
HALF_A_CENTIMETRE = 0.005 + 1e-9  # [m/s] what rounding to two decimals changes at most
PROMPT = 0.05  # [s] between a scan and its command: too short for loading the model


def scan_in_words(recording: Recording, answer: Answer) -> str:
    """Return which scan it is, for a student; its time if lost scans shift the bench's labels."""
    if answer.label and not recording.scenario.faults.scan_loss:
        return f"“{answer.label}”"
    return f"the scan at {answer.scan.t:.3f} s"


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
            actual=f"linear.x = {_four_digits(answer.speed)} m/s",
            at=answer.scan.t,
            recording=recording,
            help=help,
        )


def require_said(recording: Recording, found: Sequence[Answer], tolerance: float) -> None:
    """Fail unless the speed after each scan is one that the model, which the judge keeps, said."""
    ends = [*(answer.scan.t for answer in found[1:]), recording.duration_s]
    for answer, end in zip(found, ends, strict=True):
        what = scan_in_words(recording, answer)
        require_asked(recording, answer.scan, end, answer.speed or 0.0, tolerance, what=what)


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


def require_prompt(recording: Recording, scan: float) -> None:
    """Fail unless a command came within PROMPT of the scan's time [s] and the machine's delays."""
    times = recording.twists().t
    after = times[times >= scan]
    if len(after) and after[0] - scan <= PROMPT + recording.delay(scan, float(after[0])):
        return
    came = f"{1000 * (after[0] - scan):.0f} ms after the scan" if len(after) else "no command"
    fail(
        f"the scan at {scan:.3f} s had to wait for its command",
        expected="a command at once: the model is loaded before the first scan comes",
        actual=came,
        at=scan,
        recording=recording,
        help="This model takes 80 ms to load. Load it in __init__, not in the callback.",
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


def require_safe_drive(recording: Recording, whose: str, least: float = LEAST_WAY) -> None:
    """Fail if the robot touched something, or drove less than `least` [m] or slowly only."""
    require_alive(recording)
    require_no_contact(
        recording,
        "Watch the replay: does the command follow the scan, and does it reach 0?",
        message=f"with {whose} model the robot ran into something",
        expected="a stop in front of it",
    )
    driven, fastest = path_length(recording), recording.truth.v.max()
    if driven < least or fastest < BRISK * MAX_SPEED:
        fail(
            f"with {whose} model the robot hardly moves",
            expected=f"at least {least} m driven, and over {BRISK * MAX_SPEED:.2f} m/s "
            "where the way is free",
            actual=f"{driven:.2f} m, {fastest:.2f} m/s at most",
            at=came_to_rest(recording),
            recording=recording,
            help="Is the prediction published as it is, clipped to 0 … max_speed?",
        )


def _four_digits(speed: float) -> str:
    """Return a command with four digits, unless it is far from any speed."""
    return f"{speed:.4f}" if abs(speed) < 100 else spell(speed)
