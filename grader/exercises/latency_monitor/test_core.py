"""The core checks of exercise 9; they sum to 100 points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.checks.commands import FIELDS, is_zero, require_one_command_each, require_zero
from grader.checks.inferences import require_kept, require_one_load
from grader.checks.model_commands import require_error_log
from grader.checks.moments import first_asked
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.exercises.latency_monitor.contract import EVERYTHING, KEYS, STALE, right_statistics
from grader.exercises.latency_monitor.evidence import (
    require_as_many_commands,
    require_calls,
    require_empty,
    require_level,
    require_numbers,
    require_period,
    require_single_calls,
    require_speed_after,
    require_speeds,
)
from grader.exercises.latency_monitor.habits import (
    COUNTED,
    Habits,
    counts_right,
    habits_of,
    judged,
    levels_follow,
    misses_follow,
    says_right,
    wrong_numbers,
)
from grader.exercises.latency_monitor.reports import form_of, require_form, require_reports
from grader.recording import Recording

TIMES = "latency_times"  # shows a node's habits
HUNDRED = "latency_hundred"
CLIP = "latency_clip"  # its last calls are long
LATE_LIDAR = "latency_late_lidar"  # has max_speed 0.0
NO_MODEL = "latency_no_model"
JUDGED = ("count", "p95_ms", "missed")  # by which the level is chosen
COUNTS = "collections.deque(maxlen=100) forgets by itself; count missed calls in it."

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=(TIMES,))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel and /diagnostics."""
    for recording in recordings:
        require_wiring(recording, "latency_monitor")


@pytest.mark.check(points=10, scenarios=(TIMES, "latency_window", HUNDRED, CLIP), needs=("wiring",))
def test_one_command_per_scan(recordings: Recordings) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    *prompt, waiting = recordings
    for recording in prompt:
        require_one_command_each(recording)
    require_as_many_commands(waiting)


@pytest.mark.check(points=5, scenarios=("latency_features", HUNDRED), needs=("wiring",))
def test_features(recordings: Recordings) -> None:
    """The model gets the five features of exercise 2, in their order."""
    for recording in recordings:
        require_speeds(
            recording,
            "features",
            "Front min, mean, std within ±60°, then the minimum to the left, then to the right.",
        )


@pytest.mark.check(
    points=5,
    scenarios=(CLIP, "latency_default_speed", "latency_deadline", LATE_LIDAR),
    needs=("wiring",),
)
def test_clipped(recordings: Recordings) -> None:
    """Predictions are clipped to 0 … max_speed (0.0, 0.4, 0.8 m/s, or not set); the rest is 0."""
    clip, default, fast, held = recordings
    for recording, tag in ((clip, "clip"), (default, "clip"), (fast, "call")):
        require_speeds(recording, tag, "max(0.0, min(max_speed, prediction))")
        require_zero(recording, FIELDS[1:], "This robot only drives straight ahead.")
    require_speeds(clip, "late", "Who misses the deadline is counted in `missed`, and drives.")
    if len(clip.twists().t) >= len(clip.scans()):  # else one_command_per_scan has failed
        require_speed_after(clip, "longest", "A late prediction is counted, and drives.")
        require_speeds(clip, "waited", "A scan that waited for the model is answered as any other.")
    if held.outcome.completed:  # else stale_at_first says what ended the node
        require_speeds(held, help="max_speed 0.0 holds the robot; in Python 0.0 is false.")


@pytest.mark.check(
    points=5,
    scenarios=("latency_nothing_to_say", NO_MODEL, "latency_empty_model", "latency_late_model"),
    needs=("wiring",),
)
def test_fail_safe(recordings: Recordings) -> None:
    """NaN, a blind sector, an empty scan, no model at all: 0.0, and the node goes on."""
    held, *without = recordings
    require_speeds(
        held, "none", "Without a usable prediction: 0.0, and still one Twist for the scan."
    )
    require_speeds(held, "good", "After that a good scan counts again.")
    require_one_load(held, held.duration_s)
    for bare in without:
        require_standing(bare)


def require_standing(bare: Recording) -> None:
    """Fail unless a node without a model says so in its log, and stands."""
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
    points=10, scenarios=("latency_window", HUNDRED, LATE_LIDAR, NO_MODEL), needs=("wiring",)
)
def test_report_rate(recordings: Recordings) -> None:
    """A report comes on /diagnostics every second, from the start on, and without a model too."""
    *plain, late, bare = recordings
    for recording in plain:
        require_period(recording)
    for recording in (late, bare):
        if recording.outcome.completed:  # else stale_at_first or fail_safe says what ended the node
            require_period(recording)


@pytest.mark.check(points=10, scenarios=(TIMES,), needs=("wiring",))
def test_status_form(recordings: Recordings) -> None:
    """Each report has one status with its name and eight values, all of them decimal strings."""
    for recording in recordings:
        require_form(recording)


@pytest.mark.check(
    points=5, scenarios=(LATE_LIDAR, TIMES, "latency_raises", NO_MODEL), needs=("wiring",)
)
def test_stale_at_first(recordings: Recordings) -> None:
    """Before the first prediction: level STALE, count 0, the other numbers 0.0."""
    recording, plain, *unanswered = recordings
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
    stale = [report for report in late if report.level == STALE and report.number("count")]
    if stale:
        fail(
            "the status is STALE, though predictions have been made",
            expected="OK",
            actual="STALE",
            at=stale[0].t,
            recording=recording,
            help="STALE is for an empty window.",
        )
    empty = "An empty window has a count of 0, and 0.0 elsewhere."
    require_numbers(recording, KEYS, empty, habits, until=first_scan)
    for trial in unanswered:
        require_empty(trial, habits)


@pytest.mark.check(points=10, scenarios=(TIMES, CLIP), needs=("wiring",))
def test_mean_and_max(recordings: Recordings) -> None:
    """count, mean_ms and max_ms are those of the calls so far, in milliseconds."""
    plain, long = recordings
    require_numbers(
        plain,
        ("count", "mean_ms", "max_ms"),
        "Measure around predict only, with time.perf_counter, and multiply by 1000.",
        replace(habits_of(plain), scale=1.0),
    )
    if long.outcome.completed:
        require_numbers(
            long,
            ("max_ms",),
            "A call of more than a second is no outlier to leave out: it is what max_ms is for.",
            habits_of(plain),
            until=long.duration_s,
        )


@pytest.mark.check(points=10, scenarios=(TIMES, CLIP), needs=("wiring",))
def test_percentiles(recordings: Recordings) -> None:
    """p50_ms, p95_ms and p99_ms are percentiles by linear interpolation."""
    plain, few = recordings
    keys = ("p50_ms", "p95_ms", "p99_ms")
    help = "numpy.percentile(latencies, (50, 95, 99)) interpolates linearly by default."
    habits = habits_of(plain)
    require_numbers(plain, keys, help, habits)
    if few.outcome.completed and says_right(few, ("count", "max_ms"), habits):
        help = "numpy.percentile interpolates linearly, also between only a few latencies."
        require_numbers(few, keys, help, habits, until=few.duration_s)


@pytest.mark.check(
    points=5,
    scenarios=("latency_window", "latency_deadline", HUNDRED, LATE_LIDAR, TIMES),
    needs=("wiring",),
)
def test_window(recordings: Recordings) -> None:
    """All numbers are about the last 100 calls, and not more, however long ago they were."""
    windowed, deadline, hundred, late, plain = recordings
    habits = habits_of(plain)
    known = [key for key in ("count", "max_ms") if says_right(plain, (key,), habits.strict)]
    if counts_right((deadline, windowed), habits):
        known.append("missed")
    if says_right(plain, ("count",), habits) or not known:
        require_numbers(plain, ("count",), COUNTS, habits.strict)
    for recording in (deadline, windowed):
        require_numbers(recording, known, COUNTS, habits.strict)
    # What its model is asked there is for `features` to judge.
    require_numbers(hundred, known, COUNTS, habits.strict, until=hundred.duration_s)
    if late.outcome.completed and "count" in known:
        help = "A window of calls, not of seconds: who is not asked forgets nothing."
        require_numbers(late, ("count",), help, habits.strict, until=late.duration_s)


@pytest.mark.check(
    points=5, scenarios=("latency_deadline", "latency_window", TIMES), needs=("wiring",)
)
def test_missed(recordings: Recordings) -> None:
    """deadline_ms is the parameter (here 10.15 ms), and missed the number of calls over it."""
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
    points=10,
    scenarios=("latency_deadline", "latency_window", LATE_LIDAR, CLIP, TIMES),
    needs=("wiring",),
)
def test_levels(recordings: Recordings) -> None:
    """OK if no call missed the deadline, WARN if some did, ERROR if p95 is over it."""
    *both, late, few, plain = recordings
    habits = habits_of(plain)
    own = not (habits.right and counts_right(both, habits)) and levels_follow(both, habits)
    for recording in both:
        require_calls(recording)
        for report in () if own else judged(recording, habits):
            choices = right_statistics(recording, report.t)
            everything = right_statistics(recording, report.t, window=EVERYTHING)
            alike = {c.levels for c in choices} == {c.levels for c in everything}
            if alike or not any(wrong_numbers(recording, [report], JUDGED, habits)):
                require_level(recording, report, choices)
    for recording in (late, few, plain):
        for report in judged(recording, habits) if recording.outcome.completed else ():
            choices = right_statistics(recording, report.t)
            if report.level == STALE or not all(choice.latencies for choice in choices):
                continue  # that is for stale_at_first
            if not any(wrong_numbers(recording, [report], JUDGED, habits.strict)):
                require_level(recording, report, choices)


@pytest.mark.check(
    points=5,
    scenarios=("latency_raises", "latency_nothing_to_say", TIMES, "latency_deadline"),
    needs=("wiring",),
)
def test_raised_calls(recordings: Recordings) -> None:
    """A call that raises leads to 0.0 and is not counted; one that returns NaN is counted."""
    raises, says_nan, plain, deadline = recordings
    habits = habits_of(plain, fewest=1)  # the window's size is the business of `window`
    known = [key for key in ("mean_ms", "max_ms") if says_right(plain, (key,), habits)]
    if counts_right((deadline,), habits):
        known.append("missed")
    require_speeds(raises, "raises", "A model that raises gives no prediction: 0.0.")
    require_speeds(raises, "good", "After an exception the next scan counts again.")
    require_kept(raises)
    require_numbers(
        raises, ("count",), "Append the latency after predict has returned, not in finally.", habits
    )
    help = "Start the clock anew for each call; one that raised leaves neither time nor a miss."
    require_numbers(raises, known, help, habits)
    for recording in (raises, says_nan):
        require_single_calls(recording)
    help = "A call that returned NaN has taken its time, too: measure it like any other."
    require_numbers(says_nan, ("count", *known), help, habits)
