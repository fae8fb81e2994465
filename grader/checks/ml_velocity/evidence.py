"""The verdicts that several checks of ml_velocity share."""

from __future__ import annotations

import math

import numpy as np

from grader.checks.ml_velocity.contract import MAX_SPEED, Right, right_speed
from grader.checks.moments import came_to_rest, first_asked
from grader.checks.obstacle_avoidance.evidence import Answer, garbage, judged, spell
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.recording import Recording

SPEED_TOLERANCE = 2e-4  # [m/s]; probes show a distance of 2.5 mm
LEAST_WAY = 0.8  # [m]
BRISK = 0.8  # of max_speed: what a free way asks for
STANDING = 0.05  # [m/s]
PROMPT = 0.05  # [s] between a scan and its command: no loading in between


def require_speeds(recording: Recording, tag: str = "", help: str = "") -> None:
    """Fail unless the node drove as the contract says after every scan with this tag."""
    for answer in judged(recording, tag):
        require_speed(recording, answer, help)


def require_speed(recording: Recording, answer: Answer, help: str = "") -> None:
    """Fail unless the command in force after this scan has the right linear.x."""
    right = right_speed(recording, answer.scan)
    what = _what(recording, answer)
    if answer.speed is None:
        fail(
            f"no command has come by {what}",
            expected=f"a Twist with linear.x = {right} m/s",
            actual="nothing on /cmd_vel",
            at=answer.scan.t,
            recording=recording,
            help="Publish once at the end of the scan callback, whatever the scan was: a return "
            "before the publish() leaves the last command in force.",
        )
    if not _is_right(answer.speed, right):
        fail(
            f"{what}: wrong speed",
            expected=f"linear.x = {right} m/s",
            actual=f"linear.x = {_precise(answer.speed)} m/s",
            at=answer.scan.t,
            recording=recording,
            # a model itself may say NaN; then the check's own advice is the better one
            help=(help if math.isnan(answer.speed) else "") or garbage(answer.speed) or help,
        )


def require_prompt(recording: Recording, scan: float) -> None:
    """Fail unless a command came within PROMPT of the scan's time [s], as far as the node goes."""
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


def require_error_log(recording: Recording) -> None:
    """Fail unless the node logged an error."""
    if any(line.level in ("error", "fatal") for line in recording.log):
        return
    said = sorted({line.level for line in recording.log}) or ["nothing"]
    fail(
        "the node has no model and does not say so",
        expected="an error in the log: self.get_logger().error(…)",
        actual=f"lines of level {', '.join(said)} only" if recording.log else "an empty log",
        at=first_asked(recording),
        recording=recording,
        help="A robot that silently stands still costs an afternoon; say which file is the cause.",
    )


def require_safe_drive(recording: Recording, whose: str) -> None:
    """Fail if the robot touched something, or hardly moved, while the model drove it."""
    require_alive(recording)
    truth = recording.truth
    if truth.contact.any():
        fail(
            f"with {whose} model the robot ran into something",
            expected="a stop in front of it",
            actual="contact",
            at=truth.t[int(np.argmax(truth.contact))] / 1e9,
            recording=recording,
            help="Watch the replay: does the command follow the scan, and does it reach 0?",
        )
    way = float(np.hypot(np.diff(truth.x), np.diff(truth.y)).sum())
    if way < LEAST_WAY or truth.v.max() < BRISK * MAX_SPEED:
        fail(
            f"with {whose} model the robot hardly moves",
            expected=f"at least {LEAST_WAY} m driven, and over {BRISK * MAX_SPEED:.2f} m/s "
            "where the way is free",
            actual=f"{way:.2f} m, {truth.v.max():.2f} m/s at most",
            at=came_to_rest(recording),
            recording=recording,
            help="Is the prediction published as it is, clipped to 0 … max_speed?",
        )


def require_going_on(recording: Recording, after: float) -> None:
    """Fail unless the robot stood at some time before `after` [s] and drove again later."""
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
            help="Ask the model anew at each scan.",
        )


def _what(recording: Recording, answer: Answer) -> str:
    if answer.label and not recording.scenario.faults.scan_loss:
        return f"“{answer.label}”"
    return f"the scan at {answer.scan.t:.3f} s"


def _is_right(speed: float, right: Right) -> bool:
    return right.low - SPEED_TOLERANCE <= speed <= right.high + SPEED_TOLERANCE


def _precise(speed: float) -> str:
    """Return a command with four digits, unless it is far from any speed."""
    return f"{speed:.4f}" if abs(speed) < 100 else spell(speed)
