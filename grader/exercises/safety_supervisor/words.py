"""The words of exercise 7's own checks: which rule holds, and how often the node publishes."""

from __future__ import annotations

from grader.checks.case import Case, Runs
from grader.checks.commands import ZERO
from grader.checks.verbs import every, follows
from grader.checks.verdict import fail
from grader.exercises.safety_supervisor.contract import DIAGNOSTICS_TOPIC, LEVELS, PERIOD
from grader.recording import Recording
from sim.messages import BOOL, CMD_VEL_TOPIC, E_STOP_TOPIC, decode

LATE_COMMAND = 0.025  # [s]
HEARTBEAT, LATE_REPORT = 1.0, 0.1  # [s]
START = 0.25  # [s] in which the first command comes
OFF = 0.05  # share of the commands that may be missing, or too many


def heeds(runs: Runs, *tags: str, help: str) -> None:
    """Fail unless the node says what is allowed, to the letter, on occasions with these tags."""
    follows(runs, *tags, tolerance=ZERO, help=help, explain=own_reason)


def own_reason(case: Case) -> str:
    """Ask about the rule that the node itself names, if another one is right."""
    named, right = case.said.get("reason"), LEVELS.keys() & case.tags
    if not right or named in right or named not in LEVELS:
        return ""
    return f"Your node says {named} here, where {min(right)} is right. Why does that rule match?"


def one_a_tick(recording: Recording) -> None:
    """Fail unless commands come at 20 Hz; a zero at once may come besides when /e_stop does."""
    times = recording.twists().t
    begin = min(START - PERIOD - LATE_COMMAND, times[0]) if len(times) else 0.0
    help = "Publish at each tick of the timer, zeros too: a silent supervisor is a dead one."
    every(recording, CMD_VEL_TOPIC, PERIOD, LATE_COMMAND, begin=begin, sooner=True, help=help)
    sent = (m.data for m in recording.delivered if m.topic == E_STOP_TOPIC)
    pressed = sum(bool(decode(data, BOOL).data) for data in sent)
    came, lasted = len(times) - 1, float(times[-1] - times[0])
    due = lasted / PERIOD
    if not (1 - OFF) * due <= came <= (1 + OFF) * due + pressed:
        fail(
            "wrong rate",
            expected="20 commands a second",
            actual=f"{came / lasted:.1f} commands a second",
            at=times[0],
            recording=recording,
            help="Callbacks only keep what comes, but for a zero at once when /e_stop says true.",
        )


def reports_often(recording: Recording) -> None:
    """Fail if /diagnostics is silent for too long."""
    help = "Report also when nothing changes: that shows that the node is alive."
    every(recording, DIAGNOSTICS_TOPIC, HEARTBEAT, LATE_REPORT, sooner=True, help=help)
