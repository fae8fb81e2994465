"""The words of exercise 7's own checks: how the robot moves, and how often the node publishes."""

from __future__ import annotations

import math

import numpy as np

from grader.checks.case import Case, Runs, spell_allowed
from grader.checks.commands import ZERO
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import UNITS, between, every, follows
from grader.exercises.safety_supervisor.contract import DIAGNOSTICS_TOPIC, LEVELS, PERIOD
from grader.exercises.safety_supervisor.rules import MAX_RISE, TOLERANCE
from grader.recording import Recording
from sim.messages import BOOL, CMD_VEL_TOPIC, E_STOP_TOPIC, decode

LATE_COMMAND = 0.025  # [s]
HEARTBEAT, LATE_REPORT = 1.0, 0.1  # [s]
START = 0.25  # [s] in which the first command comes
IN_SECONDS = "Are ages in seconds? A Duration counts nanoseconds: divide by 1e9."
OFF = 0.05  # share of the commands that may be missing, or too many


def stops(runs: Runs, reason: str, help: str) -> None:
    """Fail unless the robot stands, exactly, while this reason holds it."""
    follows(runs, reason, tolerance=ZERO, help=help, explain=own_reason)


def goes_on(runs: Runs, help: str) -> None:
    """Fail if the robot does not drive, or does not turn, where it has to; how, is not asked."""
    for recording in runs:
        require_alive(recording)
    for recording, case in runs.cases("moves"):
        for name, allowed in case.allowed.items():
            said = case.said.get(name, 0.0)
            if isinstance(said, str) or not abs(said) < ZERO or (0.0, 0.0) in allowed:
                continue
            fail(
                f"{case.what}: the robot stands",
                expected=f"{name} = {spell_allowed(allowed, UNITS[name])}",
                actual=f"{name} = 0.00 {UNITS[name]}",
                at=case.at,
                recording=recording,
                help=own_reason(case) or help,
            )


def own_reason(case: Case) -> str:
    """Say which rule the node itself names, if another one is right."""
    named, right = case.said.get("reason"), sorted(LEVELS.keys() & case.tags)
    if not named or not right or named in right or named not in LEVELS:
        return ""
    asked = f"Your node says {named} here, where {right[0]} is right. Why does that rule match?"
    return f"{asked} {IN_SECONDS}" if str(named).startswith("stale") else asked


def rises_slowly(runs: Runs, help: str) -> None:
    """Fail if linear.x ever rises by more than it may from one command to the next."""
    for recording in runs:
        last = np.append(0.0, np.nan_to_num(recording.twists().linear_x, posinf=0.0, neginf=0.0))
        most = np.maximum(0.0, last[:-1]) + MAX_RISE + TOLERANCE
        between(recording, "linear.x", -math.inf, most, help)


def one_a_tick(recording: Recording) -> None:
    """Fail unless commands come at 20 Hz; a zero at once may come besides when /e_stop does."""
    times = recording.twists().t
    begin = min(START - PERIOD - LATE_COMMAND, times[0]) if len(times) else 0.0
    help = "Publish at each tick of the timer, zeros too: a silent supervisor is a dead one."
    every(recording, CMD_VEL_TOPIC, PERIOD, LATE_COMMAND, begin=begin, sooner=True, help=help)
    sent = (m.data for m in recording.delivered if m.topic == E_STOP_TOPIC)
    pressed = sum(bool(decode(data, BOOL).data) for data in sent)
    due = (times[-1] - times[0]) / PERIOD
    if not (1 - OFF) * due <= len(times) - 1 <= (1 + OFF) * due + pressed:
        fail(
            "wrong rate",
            expected="20 commands a second",
            actual=f"{(len(times) - 1) / (times[-1] - times[0]):.1f} commands a second",
            at=times[0],
            recording=recording,
            help="The timer publishes, once at each tick. Callbacks only keep what comes; "
            "but a zero at once when /e_stop says true.",
        )


def reports_often(recording: Recording) -> None:
    """Fail if /diagnostics is silent for too long."""
    help = "Report also when nothing changes: that shows that the node is alive."
    every(recording, DIAGNOSTICS_TOPIC, HEARTBEAT, LATE_REPORT, sooner=True, help=help)
