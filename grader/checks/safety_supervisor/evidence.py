"""What the node commanded and reported, and the verdicts that several checks share."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from grader.checks.commands import FIELDS, ZERO, garbage, require_zero, spell
from grader.checks.reading import published
from grader.checks.safety_supervisor.contract import LEVELS, PERIOD, Tick, ticks
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.recording import Recording

TOPIC = "/diagnostics"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
SETTLING = 0.6  # [s] after the start, in which reasons are not judged
PERIOD_TOLERANCE = 0.0025  # [s] of the mean
LONGEST_GAP = 0.075  # [s] between two commands
START = 0.25  # [s] in which the first command comes
LONGEST_REPORT_GAP = 1.1  # [s]
LEVEL_NAMES = {0: "OK", 1: "WARN", 2: "ERROR", 3: "STALE"}


@dataclass(frozen=True)
class Report:
    """One message on /diagnostics."""

    t: float  # [s]
    count: int  # statuses in it
    level: int  # of the first status; -1: there is none
    text: str  # of the first status

    @property
    def reason(self) -> str:
        """The first word of the text, if it is a reason; else an empty text."""
        match = re.match(r"\w+", self.text)
        return match[0] if match and match[0] in LEVELS else ""


def reports(recording: Recording) -> list[Report]:
    """Return what the node published on /diagnostics."""
    found = []
    for time, value in published(recording, TOPIC, DIAGNOSTICS):
        status = value.status
        level, text = (int(status[0].level), str(status[0].message)) if status else (-1, "")
        found.append(Report(time, len(status), level, text))
    return found


def require_reports(recording: Recording) -> list[Report]:
    """Return the reports; fail if there is none."""
    require_alive(recording)
    found = reports(recording)
    if not found:
        fail(
            f"not a single message came on {TOPIC}",
            expected="a DiagnosticArray when the reason changes, and every second",
            actual=f"nothing on {TOPIC}",
            at=min(LONGEST_REPORT_GAP, recording.duration_s),
            recording=recording,
            help="Publish from the control loop: when the reason is new, or the last report old.",
        )
    return found


def require_commands(
    recording: Recording,
    help: str,
    judged: Callable[[Tick], bool] = lambda tick: True,
    *,
    right: Callable[[Tick], bool] = lambda tick: tick.is_right_but_for_the_rise,
) -> None:
    """Fail unless the node ran to the end, with speed and turn rate right at the ticks judged.

    By default a speed that rises too fast is as good as a right one: it has a check of its own.
    What it commanded before it fell silent stays in force, and is judged on.
    """
    require_alive(recording)
    found = [tick for tick in ticks(recording, silences=True) if judged(tick)]
    if not found:
        fail(
            "no command came that could be judged",
            expected="20 Twists a second",
            actual="nothing on /cmd_vel when it was due",
            at=min(START, recording.duration_s),
            recording=recording,
            help=help,
        )
    for tick in found:
        if not right(tick):
            _fail_command(recording, tick, help)


def require_stops(recording: Recording, reason: str, help: str) -> None:
    """Fail unless the robot stands for as long as this reason holds, and moves when none does.

    How it moves then is for other checks to judge.
    """

    def is_stop(tick: Tick) -> bool:
        return tick.reasons == {reason}

    def is_right(tick: Tick) -> bool:
        return tick.is_right if is_stop(tick) else tick.moves

    require_commands(recording, help, lambda tick: is_stop(tick) or tick.must_move, right=is_right)


def _fail_command(recording: Recording, tick: Tick, help: str) -> None:
    speed, turn_rate = tick.values[0], tick.values[5]
    right = list(dict.fromkeys((d.reason, d.speed, d.turn_rate) for d in tick.right))
    fail(
        f"wrong command ({tick.situation.what})",
        expected=" or ".join(f"{v:.3f} m/s, {w:.2f} rad/s ({word})" for word, v, w in right),
        actual=f"{_long(speed)} m/s, {spell(turn_rate)} rad/s",
        at=tick.t,
        recording=recording,
        help=garbage(speed) or garbage(turn_rate) or _own_reason(recording, tick) or help,
    )


def _own_reason(recording: Recording, tick: Tick) -> str:
    """Say which rule the node itself names, if another one is right."""
    said = [report.reason for report in reports(recording) if report.t <= tick.t + ZERO]
    if not said or not said[-1] or said[-1] in tick.reasons:
        return ""
    right = " or ".join(sorted(tick.reasons))
    return f"Your node says {said[-1]} here, where {right} is right. Why does that rule match?"


def require_other_fields(recording: Recording) -> None:
    """Fail unless the four other fields are zero."""
    require_zero(
        recording, FIELDS[1:5], "Fill in a new Twist; only linear.x and angular.z are passed on."
    )


def require_rate(recording: Recording) -> None:
    """Fail unless commands came at 20 Hz from the start to the end."""
    require_alive(recording)
    times = recording.twists().t
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
            help="Only the timer publishes, not the callbacks of /scan and /cmd_vel_raw.",
        )


def require_reasons(recording: Recording, help: str) -> None:
    """Fail if a report gives a wrong reason.

    A reason is due at the second tick at which it alone is right. It is judged only where the
    commands are right: wrong ones have a check of their own.
    """
    said = require_reports(recording)
    times = np.array([report.t for report in said])
    found = ticks(recording)
    judged = 0
    for before, tick in pairwise(found):
        clear = len(tick.reasons) == 1 and before.reasons == tick.reasons
        if tick.t <= SETTLING or not clear or not (before.is_right and tick.is_right):
            continue
        judged += 1
        newest = int(np.searchsorted(times, tick.t + ZERO, side="right")) - 1
        reason = next(iter(tick.reasons))
        if newest < 0 or said[newest].reason != reason:
            text = f"“{said[newest].text[:60]}”" if newest >= 0 else f"nothing on {TOPIC} yet"
            fail(
                f"wrong reason ({tick.situation.what})",
                expected=f"a text that begins with {reason}",
                actual=text,
                at=tick.t,
                recording=recording,
                help=help,
            )
    if not judged:
        fail(
            "no right command came whose reason could be judged",
            expected="right commands first, then the reasons for them",
            actual="wrong commands",
            at=next((tick.t for tick in found if not tick.is_right), None),
            recording=recording,
            help="Get the checks of the commands right first.",
        )


def require_levels(recording: Recording) -> None:
    """Fail unless every report has the level of the reason that it gives."""
    for report in require_reports(recording):
        wanted = LEVELS.get(report.reason)
        if wanted is None or report.level == wanted:
            continue
        fail(
            f"wrong level of “{report.text[:60]}”",
            expected=f"{LEVEL_NAMES[wanted]} ({wanted})",
            actual=f"{LEVEL_NAMES.get(report.level, 'garbage')} ({report.level})",
            at=report.t,
            recording=recording,
            help="level is a byte: assign DiagnosticStatus.OK, .WARN or .ERROR, not a number.",
        )


def require_text(recording: Recording) -> None:
    """Fail unless every report has one status whose text begins with a reason word."""
    for report in require_reports(recording):
        if report.count == 1 and report.reason:
            continue
        fail(
            f"a report with {report.count} statuses"
            if report.count != 1
            else "a report without a reason",
            expected="one status, whose message begins with one of: " + ", ".join(LEVELS),
            actual=f"{report.count} statuses" if report.count != 1 else f"“{report.text[:60]}”",
            at=report.t,
            recording=recording,
            help="status.message begins with the word itself; anything may follow after a space.",
        )


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


def _long(speed: float) -> str:
    return f"{speed:.3f}" if abs(speed) < 1e6 else f"{speed:.3g}"
