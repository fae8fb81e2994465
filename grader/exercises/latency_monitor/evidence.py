"""Whether commands and reports are right: the verdicts that several checks of exercise 9 share."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable

import numpy as np

from grader.checks.commands import WATCHDOG, ZERO, answers, is_zero
from grader.checks.inferences import questions
from grader.checks.model_commands import require_asked
from grader.checks.predictions import (
    TOLERANCE,
    Prediction,
    max_speed,
    predictions,
    rounded,
)
from grader.checks.turns import turns
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.latency_monitor.contract import (
    KEYS,
    LEVELS,
    PERIOD,
    PERIOD_TOLERANCE,
    TOPIC,
    Statistics,
    right_statistics,
)
from grader.exercises.latency_monitor.habits import RIGHT, Habits, judged, wrong_numbers
from grader.exercises.latency_monitor.reports import Report
from grader.recording import Inference, Recording

HALF = 0.5  # [ms] what rounding may change
CROWD = 2  # reports a second: more timers than one
MOST_CALLS = 2  # of predict for each scan, on average
LATEST_CALL = 0.5  # [s] from a scan to its call of predict
LATE_IN_REAL_TIME = 0.1  # of the scans, whose calls may come later on a busy machine


def require_speeds(recording: Recording, tag: str = "", help: str = "") -> None:
    """Fail unless its clipped prediction, or 0.0, followed each scan (with this tag)."""
    require_alive(recording)
    twists, bench = recording.twists(), recording.scenario.bench_scans
    said = predictions(recording)
    if not said:
        fail("no scan was sent", recording=recording)
    scans, first = turns(recording)
    replies = answers(recording)  # without what a watchdog says
    for number, right in enumerate(said[: len(scans)]):
        if tag and tag not in bench[number].tags:
            continue
        begin = int(first[number])
        end = begin + replies[number].count
        speed = float(twists.linear_x[end - 1]) if end > begin else None
        if speed is not None and right.allows(speed):
            if abs(speed) > ZERO:
                what = f"the scan at {right.scan.t:.2f} s"
                came = float(twists.t[end - 1])
                require_asked(recording, right.scan, came, speed, TOLERANCE, what=what)
            continue
        label = f"“{bench[number].label}”" if bench else f"the scan at {right.scan.t:.2f} s"
        fail(
            f"{label}: wrong speed",
            expected=f"linear.x = {right.text}",
            actual="no command" if speed is None else f"linear.x = {speed:.4g} m/s",
            at=right.scan.t,
            recording=recording,
            help=rounded(speed, right) or help,
        )


def require_speed_after(recording: Recording, tag: str, help: str) -> None:
    """Fail unless the prediction for the scan with this tag is among the commands after it.

    Other scans have waited for it, and the commands for all of them come at the same moment.
    """
    twists, bench = recording.twists(), recording.scenario.bench_scans
    for spec, right in zip(bench, predictions(recording), strict=False):
        after = twists.linear_x[twists.t > right.scan.t]
        if tag not in spec.tags or any(right.allows(float(speed)) for speed in after):
            continue
        fail(
            f"“{spec.label}”: no command with its speed",
            expected=f"linear.x = {right.text}, once predict has returned",
            actual=", ".join(f"{speed:.4g}" for speed in after[:4].tolist()) or "no command",
            at=right.scan.t,
            recording=recording,
            help=help,
        )


def require_as_many_commands(recording: Recording) -> None:
    """Fail unless as many commands came as scans, also of those that came during a long call."""
    require_alive(recording)
    scans, commands = len(recording.scans()), len(recording.twists().t)
    if not scans <= commands <= scans + _watchdogs(recording):
        longest = max((call.took for call in recording.inferences), default=0) / 1e9
        fail(
            f"{commands} commands followed {scans} scans",
            expected=f"{scans}: exactly one Twist for each scan",
            actual=f"{commands}; the longest call of predict took {longest:.1f} s",
            at=recording.scans()[-1].t,
            recording=recording,
            help="Some of the scans came while predict still ran. A subscription keeps as many as "
            "its depth says, 5 with qos_profile_sensor_data; each wants a Twist."
            if commands < scans
            else "Look for a timer or a second publish().",
        )


def _watchdogs(recording: Recording) -> int:
    """Return how many commands may be a watchdog's: zero, and long after the newest scan."""
    twists = recording.twists()
    scans = np.concatenate(([-math.inf], recording.times("/scan")))
    newest = scans[np.searchsorted(scans, twists.t, side="right") - 1]
    zero = np.all(is_zero(twists.values), axis=1)
    return int((zero & (twists.t > newest + WATCHDOG)).sum())


def require_empty(recording: Recording, habits: Habits) -> None:
    """Fail unless a status that rightly counts no call is STALE, and has zeros elsewhere."""
    if not recording.outcome.completed or not len(recording.of(TOPIC)):  # other checks say so
        return
    for report in judged(recording, habits):
        choices = right_statistics(recording, report.t)
        if report.number("count") or all(choice.latencies for choice in choices):
            continue
        require_level(recording, report, choices)
        for _, key, _, wanted in wrong_numbers(recording, [report], KEYS, habits):
            fail(
                f"{key} is wrong while no call has returned yet",
                expected=_spell(key, wanted[0].numbers[key]),
                actual=f"“{report.texts[key]}”" if key in report.texts else f"no value {key}",
                at=report.t,
                recording=recording,
                help="An empty window has a count of 0, and 0.0 elsewhere.",
            )


def require_calls(recording: Recording) -> None:
    """Fail unless the model was asked about each scan that has features, one row at a time.

    What is measured is up to the node: who never asks, or always the same, has numbers that are
    right and say nothing.
    """
    require_alive(recording)
    scans, _ = turns(recording)
    said = predictions(recording)[: len(scans)]
    calls = sorted(questions(recording, "predict", 0.0, math.inf), key=_asked)
    if len(calls) > MOST_CALLS * len(recording.scans()):
        fail(
            f"predict was called {len(calls):,} times for {len(recording.scans()):,} scans",
            expected="one call of predict for each scan",
            actual=f"more than {MOST_CALLS} for each",
            at=calls[MOST_CALLS * len(recording.scans())].asked / 1e9,
            recording=recording,
            help="What is measured is what drives the robot: measure those calls, and no others.",
        )
    missed, place = [], 0
    for right in said:
        if right.missing:  # blind, or the model says nothing: only who asks can know that
            continue
        place = bisect_left(calls, right.scan.t - recording.slack, place, key=_asked)
        late = bisect_right(calls, right.scan.t + LATEST_CALL + recording.slack, place, key=_asked)
        about = (i for i in range(place, late) if _is_about(recording, calls[i], right))
        found = next(about, None)
        if found is None:
            missed.append(right)
        else:
            place = found + 1
    if len(missed) <= (LATE_IN_REAL_TIME * len(said) if recording.live is not None else 0):
        return
    at, asked = missed[0].scan.t, len(calls)
    fail(
        f"the model was not asked about the scan at {at:.2f} s",
        expected=f"one call of predict, with one row, that returns {missed[0].text}",
        actual=f"{asked} calls in all; {len(missed)} of {len(said)} scans without one",
        at=at,
        recording=recording,
        help="Call predict for each scan, and measure that call: numbers about no calls, or about "
        "others, say nothing about the model that drives.",
    )


def require_single_calls(recording: Recording) -> None:
    """Fail if, from the first scan on, the model was asked more often than scans had come."""
    scans = [scan.t for scan in recording.scans()]
    if not scans:  # a node that dies before the first one
        return
    calls = sorted(questions(recording, "predict", scans[0], math.inf), key=_asked)
    for number, at in enumerate(map(_asked, calls), 1):
        come = bisect_right(scans, at + recording.slack)
        if number > come:
            fail(
                f"predict was called again for the scan at {scans[come - 1]:.2f} s",
                expected="one call of predict for each scan that has features",
                actual=f"call {number} at {at:.3f} s, though only {come} scans had come",
                at=at,
                recording=recording,
                help="NaN or an exception is 0.0 for this scan: the next one is asked anew.",
            )


def _asked(call: Inference) -> float:
    """Return when a call began [s]."""
    return call.asked / 1e9


def _is_about(recording: Recording, call: Inference, right: Prediction) -> bool:
    """Tell whether a call was about a scan: it had one row, and returned what is right for it."""
    limit = max_speed(recording.scenario)
    return len(call.said) == 1 and right.allows(max(0.0, min(limit, call.said[0])))


def require_period(recording: Recording) -> None:
    """Fail unless a report came every second, from the start on; one more at the start may be."""
    require_alive(recording)
    tolerance = PERIOD_TOLERANCE + recording.slack
    reports = recording.times(TOPIC).tolist()
    begin = reports.pop(0) if reports and reports[0] <= tolerance else 0.0
    times = [begin, *reports]
    gaps = np.diff([*times, recording.duration_s])
    wrong = np.flatnonzero(np.abs(gaps[:-1] - PERIOD) > tolerance)
    if recording.live is not None:  # its timer may have started before the recording
        wrong = wrong[(wrong > 0) | (gaps[wrong] > PERIOD)]
    if not len(wrong) and gaps[-1] > PERIOD + tolerance:
        wrong = np.array([len(gaps) - 1])
    if len(wrong):
        i = int(wrong[0])
        fail(
            "the reports do not come at 1 Hz",
            expected=f"one every {PERIOD:.0f} s, from the start on",
            actual=f"{gaps[i]:.2f} s between two of them ({len(times) - 1} in all)",
            at=times[i] + float(gaps[i]),
            recording=recording,
            help="Is a new timer made with every scan? Make one, in the constructor."
            if len(times) > CROWD * recording.duration_s
            else "One timer of 1.0 s publishes, whether or not there was a prediction.",
        )


def require_numbers(
    recording: Recording,
    keys: Iterable[str],
    help: str,
    habits: Habits = RIGHT,
    *,
    full_windows: bool = True,
    until: float = math.inf,
) -> None:
    """Fail unless these values are right in each report (until a time [s]).

    Without `full_windows` only reports from before the hundred-and-first call are judged.
    """
    if until == math.inf:
        require_calls(recording)
    reports = judged(recording, habits, full_windows=full_windows, until=until)
    for report, key, number, choices in wrong_numbers(recording, reports, keys, habits):
        said = report.number("count")  # of several that are right the one that is meant
        right = next((c for c in choices if c.numbers["count"] == said), choices[0]).numbers
        wanted = right[key]
        fail(
            f"{key} is wrong",
            expected=_spell(key, wanted) + f", over {right['count']:.0f} calls",
            actual=f"“{report.texts[key]}”" if key in report.texts else f"no value {key}",
            at=report.t,
            recording=recording,
            help=_slip(key, number, wanted) or help,
        )
    if not reports:
        fail("no report could be judged", recording=recording)


def _slip(key: str, number: float, wanted: float) -> str:
    """Say so if a latency is only in another unit, or rounded."""
    if not key.endswith("_ms") or not wanted or not number or not math.isfinite(number):
        return ""
    for factor, unit in ((1e3, "microseconds"), (1e-3, "seconds")):
        if math.isclose(number, factor * wanted, rel_tol=1e-2):
            return f"These are {unit}; milliseconds are asked for: 1000 times the seconds."
    if number == round(number) and abs(number - wanted) <= HALF:
        return "Rounded to whole milliseconds it says too little: write f'{number:.3f}'."
    return ""


def require_level(recording: Recording, report: Report, choices: tuple[Statistics, ...]) -> None:
    """Fail unless a report has the level that belongs to its calls."""
    if any(report.level in choice.levels for choice in choices):
        return
    numbers = choices[0].numbers
    known = 0 <= report.level < len(LEVELS)
    fail(
        "the status has the wrong level",
        expected=f"{LEVELS[choices[0].level]}: {numbers['missed']:.0f} of {numbers['count']:.0f} "
        f"calls missed {numbers['deadline_ms']:g} ms, p95 is {numbers['p95_ms']:.1f} ms",
        actual=LEVELS[report.level] if known else f"{report.level}, which is not a level",
        at=report.t,
        recording=recording,
        help="STALE before the first prediction, ERROR if p95 > deadline, WARN if any missed, "
        "else OK."
        if known
        else "level is a byte: assign DiagnosticStatus.OK, .WARN, … and not a number.",
    )


def _spell(key: str, number: float) -> str:
    return f"{number:.0f}" if key in ("count", "missed") else f"{number:.2f} ms"
