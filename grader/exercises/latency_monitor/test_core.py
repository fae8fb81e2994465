"""The core checks of exercise 9; they sum to 100 points."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, TIMING, WIRING, check
from grader.checks.model_commands import loads_once, predicts, stands
from grader.checks.verbs import answers_once, every, only_linear_x, wired
from grader.exercises.latency_monitor.calls import answers_all, asks_once_each
from grader.exercises.latency_monitor.reports import PERIOD, PERIOD_TOLERANCE, TOPIC, reports

TIMES = "latency_times"
FULL = "latency_window"  # more than a hundred calls
HUNDRED = "latency_hundred"
CLIP = "latency_clip"  # three scans wait for its longest call
DEADLINE = "latency_deadline"
LATE_LIDAR = "latency_late_lidar"  # max_speed is 0.0; after a second a minute without a scan
RAISES = "latency_raises"
SAYS_NAN = "latency_nothing_to_say"
NO_MODEL = ("latency_no_model", "latency_empty_model", "latency_late_model")


@check(points=5, asks=WIRING, task=1, scenarios=(TIMES,), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel and /diagnostics."""
    wired(runs)


@check(points=10, asks=DECISION, task=1, scenarios=(TIMES, FULL, HUNDRED, CLIP))
def test_one_command_per_scan(runs: Runs) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    answers_once(runs.only(TIMES, FULL, HUNDRED))
    answers_all(runs[CLIP])


@check(points=5, asks=DECISION, task=1, scenarios=("latency_features", HUNDRED))
def test_features(runs: Runs) -> None:
    """The model gets the five features of exercise 2, in their order."""
    help = "Front min, mean, std within ±60°, then the minimum to the left, then to the right."
    predicts(runs, help=help)


@check(
    points=5, asks=SAFETY, task=1, scenarios=(CLIP, "latency_default_speed", DEADLINE, LATE_LIDAR)
)
def test_clipped(runs: Runs) -> None:
    """Predictions are clipped to 0 … max_speed (0.0, 0.4, 0.8 m/s, or not set); the rest is 0."""
    help = "max(0.0, min(max_speed, prediction)), also of a scan that waited or a call that is late"
    predicts(runs.only(CLIP), "clip", "late", "waited", help=help)
    predicts(runs.only("latency_default_speed", DEADLINE), help=help)
    predicts(runs.only(LATE_LIDAR), help="max_speed 0.0 holds the robot; in Python 0.0 is false.")
    only_linear_x(runs, help="This robot only drives straight ahead.")


@check(points=2, asks=SAFETY, task=1, scenarios=(SAYS_NAN,))
def test_blind_sector(runs: Runs) -> None:
    """A blind sector, or an empty scan: 0.0."""
    predicts(runs, "blind")


@check(points=3, asks=SAFETY, task=1, scenarios=(SAYS_NAN, *NO_MODEL))
def test_fail_safe(runs: Runs) -> None:
    """NaN or ±inf from the model, no model at all: 0.0, and the node goes on, blind or not."""
    held = runs.only(SAYS_NAN)
    help = "Without a usable prediction: 0.0, and still one Twist; then a good scan counts again."
    predicts(held, "good", "none", help=help)
    answers_once(held)
    loads_once(held)
    stands(runs.only(*NO_MODEL))


@check(
    points=10, asks=TIMING, task=5, scenarios=(FULL, HUNDRED, LATE_LIDAR, NO_MODEL[0]), hint="5.1"
)
def test_report_rate(runs: Runs) -> None:
    """A report comes on /diagnostics every second, from the start on, and without a model too."""
    help = "One timer of 1.0 s, made in the constructor, publishes, whatever the calls were."
    for recording in runs:
        every(recording, TOPIC, PERIOD, PERIOD_TOLERANCE, help=help)


@check(points=10, asks=WIRING, task=5, scenarios=(TIMES,), hint="5.1")
def test_status_form(runs: Runs) -> None:
    """Each report has one status with its name and eight values, all of them decimal strings."""
    help = (
        "status is a list of one element, and its values are "
        "KeyValue(key=…, value=f'{number:.3f}'), 0.0 without any call."
    )
    reports(runs, "form", help=help)


@check(points=5, asks=STATE, task=4, scenarios=(LATE_LIDAR, RAISES, NO_MODEL[0]), hint="3.2")
def test_stale_at_first(runs: Runs) -> None:
    """Before the first prediction: level STALE, count 0, the other numbers 0.0."""
    help = "An empty window is STALE, has a count of 0, and 0.0 elsewhere."
    reports(runs, "empty", help=help)
    reports(runs.only(LATE_LIDAR), "level", help="STALE is for an empty window.")


@check(points=10, asks=DECISION, task=3, scenarios=(TIMES, CLIP), hint="2.2")
def test_mean_and_max(runs: Runs) -> None:
    """count, mean_ms and max_ms are those of the calls so far, in milliseconds."""
    asks_once_each(runs.only(TIMES))
    help = "Measure around predict only, 1000 times the seconds, and leave no call out."
    reports(runs, "count", "mean_ms", "max_ms", help=help)


@check(points=10, asks=DECISION, task=3, scenarios=(TIMES, CLIP), hint="3.1")
def test_percentiles(runs: Runs) -> None:
    """p50_ms, p95_ms and p99_ms are percentiles by linear interpolation."""
    asks_once_each(runs.only(TIMES))
    help = "numpy.percentile(latencies, (50, 95, 99)) interpolates linearly, between a few, too."
    reports(runs, "p50_ms", "p95_ms", "p99_ms", help=help)


@check(points=5, asks=STATE, task=3, scenarios=(FULL, DEADLINE, HUNDRED, LATE_LIDAR), hint="2.3")
def test_window(runs: Runs) -> None:
    """All numbers are about the last 100 calls, and not more, however long ago they were."""
    asks_once_each(runs.only(FULL, DEADLINE))
    help = "collections.deque(maxlen=100) forgets by itself, and nothing else is to be forgotten."
    reports(runs, "count", "max_ms", "missed", help=help)


@check(points=5, asks=DECISION, task=3, scenarios=(DEADLINE, FULL), hint="2.3")
def test_missed(runs: Runs) -> None:
    """deadline_ms is the parameter (here 10.15 ms), and missed the number of calls over it."""
    asks_once_each(runs)
    help = "self.declare_parameter('deadline_ms', 100.0); missed: latency > deadline."
    reports(runs, "deadline_ms", "missed", help=help)


@check(
    points=10,
    asks=DECISION,
    task=4,
    scenarios=(DEADLINE, FULL, LATE_LIDAR, CLIP, TIMES),
    hint="4.1",
)
def test_levels(runs: Runs) -> None:
    """OK if no call missed the deadline, WARN if some did, ERROR if p95 is over it."""
    asks_once_each(runs.only(DEADLINE, FULL))
    help = (
        "ERROR if p95 > deadline, else WARN if any call missed it, else OK; "
        "assign DiagnosticStatus.WARN, a byte, and not a number."
    )
    reports(runs, "level", help=help)


@check(points=5, asks=STATE, task=3, scenarios=(RAISES, SAYS_NAN), hint="2.4")
def test_raised_calls(runs: Runs) -> None:
    """A call that raises leads to 0.0 and is not counted; one that returns NaN is counted."""
    raises = runs.only(RAISES)
    asks_once_each(runs)
    predicts(raises, help="A model that raises gives no prediction: 0.0. The next scan is asked.")
    loads_once(raises)
    help = "Start the clock anew for each call, and append after predict has returned, NaN or not."
    reports(runs, "count", "mean_ms", "max_ms", "missed", help=help)
