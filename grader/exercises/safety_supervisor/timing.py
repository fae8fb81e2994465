"""How often the node speaks: one command a tick, and a report every second."""

from __future__ import annotations

import numpy as np

from grader.checks.commands import ZERO
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.safety_supervisor.contract import PERIOD
from grader.exercises.safety_supervisor.evidence import LONGEST_REPORT_GAP, START, require_reports
from grader.recording import Floats, Recording
from sim.messages import BOOL, E_STOP_TOPIC, decode

PERIOD_TOLERANCE = 0.0025  # [s] of the mean
LONGEST_GAP = 0.075  # [s] between two commands
AT_ONCE = 0.01  # [s] after /e_stop, in which a zero Twist may come besides


def require_rate(recording: Recording) -> None:
    """Fail unless commands came at 20 Hz from the start to the end."""
    require_alive(recording)
    times = _in_time(recording)
    begin = min(START - LONGEST_GAP, times[0]) if len(times) else 0.0
    bounds = np.concatenate([[begin], times, [recording.duration_s]])
    gaps = np.diff(bounds)
    widest = int(np.argmax(gaps))
    if gaps[widest] > LONGEST_GAP + recording.slack:
        fail(
            f"no command for {gaps[widest]:.2f} s",
            expected="one every 0.05 s, whatever has arrived or not",
            actual=f"none between {bounds[widest]:.2f} and {bounds[widest + 1]:.2f} s",
            at=float(bounds[widest]),
            recording=recording,
            help="Publish at each tick of the timer, zeros too: a silent supervisor is a dead one.",
        )
    mean = float(np.mean(np.diff(times)))
    if abs(mean - PERIOD) > PERIOD_TOLERANCE:
        fail(
            "wrong rate",
            expected="20 commands a second",
            actual=f"{1.0 / mean:.1f} commands a second",
            at=float(times[0]),
            recording=recording,
            help="The timer publishes, once at each tick. Callbacks only remember what they hear; "
            "but a zero at once when /e_stop says true.",
        )


def _in_time(recording: Recording) -> Floats:
    """Return when commands came [s], without those that may come besides when /e_stop does."""
    twists = recording.twists()
    said = (m for m in recording.delivered if m.topic == E_STOP_TOPIC and m.type == BOOL)
    pressed = [message.time / 1e9 for message in said if decode(message.data, BOOL).data]
    times = twists.t
    if not pressed or not len(times):
        return times
    newest = np.searchsorted(pressed, times, side="right") - 1
    since = times - np.array(pressed)[np.maximum(newest, 0)]
    at_once = (newest >= 0) & (since <= AT_ONCE + recording.slack)
    stands = np.all(np.abs(twists.values) < ZERO, axis=1)
    # What no other command could stand in for is the tick's own.
    around = np.append(times[1:], recording.duration_s) - np.append(0.0, times[:-1])
    in_time: Floats = times[~(at_once & stands & (around <= LONGEST_GAP))]
    return in_time


def require_heartbeat(recording: Recording) -> None:
    """Fail if /diagnostics was silent for too long."""
    times = np.array([report.t for report in require_reports(recording)])
    bounds = np.concatenate([[0.0], times, [recording.duration_s]])
    gaps = np.diff(bounds)
    widest = int(np.argmax(gaps))
    if gaps[widest] > LONGEST_REPORT_GAP + recording.slack:
        fail(
            f"no report for {gaps[widest]:.2f} s",
            expected=f"one at least every second (gaps up to {LONGEST_REPORT_GAP} s)",
            actual=f"none between {bounds[widest]:.2f} and {bounds[widest + 1]:.2f} s",
            at=float(bounds[widest]),
            recording=recording,
            help="Report also when nothing changes: whoever listens must know that you are alive.",
        )
