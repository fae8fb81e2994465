"""The core checks of exercise 9; they sum to 100 points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.checks.commands import FIELDS, is_zero, require_one_command_each, require_zero
from grader.checks.latency_monitor.contract import EVERYTHING, KEYS, STALE, right_statistics
from grader.checks.latency_monitor.evidence import (
    require_calls,
    require_level,
    require_numbers,
    require_period,
    require_speeds,
)
from grader.checks.latency_monitor.habits import (
    COUNTED,
    Habits,
    habits_of,
    judged,
    levels_follow,
    misses_follow,
    says_right,
)
from grader.checks.latency_monitor.reports import form_of, require_form, require_reports
from grader.checks.model_commands import require_error_log
from grader.checks.moments import first_asked
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording

TIMES = "latency_times"  # shows a node's habits
HUNDRED = "latency_hundred"
COUNTS = "collections.deque(maxlen=100) forgets by itself; count missed calls in it."

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=(TIMES,))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel and /diagnostics."""
    for recording in recordings:
        require_wiring(recording, "latency_monitor")


@pytest.mark.check(points=10, scenarios=(TIMES, "latency_window", HUNDRED), needs=("wiring",))
def test_one_command_per_scan(recordings: Recordings) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    for recording in recordings:
        require_one_command_each(recording)


@pytest.mark.check(points=5, scenarios=("latency_features", HUNDRED), needs=("wiring",))
def test_features(recordings: Recordings) -> None:
    """The model gets the five features of exercise 2, in their order."""
    for recording in recordings:
        require_speeds(
            recording,
            "features",
            "Front min, mean, std within ±60°, then the minimum to the left, then to the right.",
        )


@pytest.mark.check(points=5, scenarios=("latency_clip", "latency_default_speed"), needs=("wiring",))
def test_clipped(recordings: Recordings) -> None:
    """Predictions are clipped to 0 … max_speed (0.4 m/s, or not set); all other fields are 0."""
    for recording in recordings:
        require_speeds(recording, "clip", "max(0.0, min(max_speed, prediction))")
        require_zero(recording, FIELDS[1:], "This robot only drives straight ahead.")


@pytest.mark.check(
    points=5, scenarios=("latency_nothing_to_say", "latency_no_model"), needs=("wiring",)
)
def test_fail_safe(recordings: Recordings) -> None:
    """NaN, a blind sector, an empty scan, no model at all: 0.0, and the node goes on."""
    held, bare = recordings
    require_speeds(
        held, "none", "Without a usable prediction: 0.0, and still one Twist for the scan."
    )
    require_speeds(held, "good", "After that a good scan counts again.")
    require_alive(bare)
    if not len(bare.twists().t):
        fail(
            "without a model the node publishes nothing",
            expected="0.0 for every scan",
            at=first_asked(bare),
            recording=bare,
        )
    moving = np.flatnonzero(~is_zero(bare.twists().linear_x))
    if len(moving):
        fail(
            "the robot was told to drive without a model",
            expected="0.0 for every scan",
            actual=f"linear.x = {bare.twists().linear_x[moving[0]]:.3g} m/s",
            at=float(bare.twists().t[moving[0]]),
            recording=bare,
            help="No model: an error in the log, and 0.0.",
        )
    require_error_log(bare, "the node has no model, and its log does not say so")


@pytest.mark.check(
    points=10, scenarios=("latency_window", HUNDRED, "latency_late_lidar"), needs=("wiring",)
)
def test_report_rate(recordings: Recordings) -> None:
    """A report comes on /diagnostics every second, from the start on."""
    *plain, late = recordings
    for recording in plain:
        require_period(recording)
    if late.outcome.completed:  # else stale_at_first says what ended the node
        require_period(late)


@pytest.mark.check(points=10, scenarios=(TIMES,), needs=("wiring",))
def test_status_form(recordings: Recordings) -> None:
    """Each report has one status with its name and eight values, all of them decimal strings."""
    for recording in recordings:
        require_form(recording)


@pytest.mark.check(points=5, scenarios=("latency_late_lidar", TIMES), needs=("wiring",))
def test_stale_at_first(recordings: Recordings) -> None:
    """Before the first prediction: level STALE, count 0, the other numbers 0.0."""
    recording, plain = recordings
    habits = Habits(form_of(plain))
    reports, first_scan = require_reports(recording, habits.form), recording.scans()[0].t
    early = [report for report in reports if report.t < first_scan]
    if not early:
        fail(
            "no report came before the first scan",
            expected=f"one every second; the first scan came at {first_scan:.2f} s",
            actual=f"the first one at {reports[0].t:.2f} s",
            at=first_scan,
            recording=recording,
            help="Report at each tick, also when there is nothing to report yet.",
        )
    for report in early:
        require_level(recording, report, right_statistics(recording, report.t))
    late = [report for report in reports if report.t > first_scan + 0.5]
    if not any(call.method == "predict" for call in recording.inferences):
        fail(
            "the model was never asked, so nothing can be said of when it had answered",
            expected="a call of predict for each scan",
            actual="none",
            at=first_scan,
            recording=recording,
        )
    if late and late[-1].level == STALE:
        fail(
            "the status is still STALE, though predictions have been made",
            expected="OK",
            actual="STALE",
            at=late[-1].t,
            recording=recording,
            help="STALE is for an empty window.",
        )
    empty = "An empty window has a count of 0, and 0.0 elsewhere."
    require_numbers(recording, KEYS, empty, habits, until=first_scan)


@pytest.mark.check(points=10, scenarios=(TIMES,), needs=("wiring",))
def test_mean_and_max(recordings: Recordings) -> None:
    """count, mean_ms and max_ms are those of the calls so far, in milliseconds."""
    (plain,) = recordings
    require_numbers(
        plain,
        ("count", "mean_ms", "max_ms"),
        "Measure around predict only, with time.perf_counter, and multiply by 1000.",
        replace(habits_of(plain), scale=1.0),
    )


@pytest.mark.check(points=10, scenarios=(TIMES,), needs=("wiring",))
def test_percentiles(recordings: Recordings) -> None:
    """p50_ms, p95_ms and p99_ms are percentiles by linear interpolation."""
    (plain,) = recordings
    require_numbers(
        plain,
        ("p50_ms", "p95_ms", "p99_ms"),
        "numpy.percentile(latencies, (50, 95, 99)) interpolates linearly by default.",
        habits_of(plain),
    )


@pytest.mark.check(
    points=5, scenarios=("latency_window", "latency_deadline", HUNDRED, TIMES), needs=("wiring",)
)
def test_window(recordings: Recordings) -> None:
    """All numbers are about the last 100 calls, and not more."""
    windowed, deadline, hundred, plain = recordings
    habits = habits_of(plain)
    known = [key for key in ("count", "max_ms") if says_right(plain, (key,), habits.strict)]
    if says_right(deadline, COUNTED, habits.strict, full_windows=False):
        known.append("missed")
    if says_right(plain, ("count",), habits) or not known:
        require_numbers(plain, ("count",), COUNTS, habits.strict)
    for recording in (deadline, windowed, hundred):
        require_numbers(recording, known, COUNTS, habits.strict)


@pytest.mark.check(
    points=5, scenarios=("latency_deadline", "latency_window", TIMES), needs=("wiring",)
)
def test_missed(recordings: Recordings) -> None:
    """deadline_ms is the parameter (here 10 ms), and missed the number of calls over it."""
    *both, plain = recordings
    habits = habits_of(plain)
    own = not habits.right and misses_follow(both, habits)
    for recording in both:
        require_numbers(
            recording,
            COUNTED[:1] if own else COUNTED,
            "self.declare_parameter('deadline_ms', 100.0); missed: latency > deadline.",
            habits.strict,
            full_windows=False,
        )


@pytest.mark.check(
    points=10, scenarios=("latency_deadline", "latency_window", TIMES), needs=("wiring",)
)
def test_levels(recordings: Recordings) -> None:
    """OK if no call missed the deadline, WARN if some did, ERROR if p95 is over it."""
    *both, plain = recordings
    habits = habits_of(plain)
    counts = says_right(both[0], COUNTED, habits.strict, full_windows=False)
    own = not (habits.right and counts) and levels_follow(both, habits)
    for recording in both:
        require_calls(recording)
        for report in () if own else judged(recording, habits):
            choices = right_statistics(recording, report.t)
            everything = right_statistics(recording, report.t, window=EVERYTHING)
            if {c.levels for c in choices} == {c.levels for c in everything}:
                require_level(recording, report, choices)


@pytest.mark.check(
    points=5, scenarios=("latency_raises", "latency_nothing_to_say", TIMES), needs=("wiring",)
)
def test_raised_calls(recordings: Recordings) -> None:
    """A call that raises leads to 0.0 and is not counted; one that returns NaN is counted."""
    raises, says_nan, plain = recordings
    habits = habits_of(plain)
    require_speeds(raises, "raises", "A model that raises gives no prediction: 0.0.")
    require_speeds(raises, "good", "After an exception the next scan counts again.")
    require_numbers(
        raises, ("count",), "Append the latency after predict has returned, not in finally.", habits
    )
    require_numbers(
        says_nan, ("count",), "A call that returned NaN has taken its time, too.", habits
    )
