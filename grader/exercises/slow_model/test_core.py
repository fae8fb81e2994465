"""The core checks of exercise 5; they sum to 100 points."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, TIMING, WIRING, check
from grader.checks.model_commands import ERRORS, SILENTLY, loads_once
from grader.checks.predictions import TOLERANCE
from grader.checks.verbs import follows, logs, only_linear_x, reacts, wired
from grader.exercises.slow_model.contract import LATEST_STOP, silence
from grader.exercises.slow_model.words import heeds, keeps_period, stands

LEADER, FAST, SLOW_LIDAR = "slow_leader", "slow_fast_model", "slow_lidar_5_hz"
LONELY = "slow_alone"
TOO_SLOW = "slow_too_slow"  # and fast in the end
DROPOUT, LATE_SCANS, STAMPS = "slow_dropout", "slow_late_scans", "slow_stamps"
HELD, CLIP = "slow_held", ("slow_clip", "slow_default_speed")
RAISES, NOT_FINITE, BLIND = "slow_raises", "slow_nan", "slow_blind"
WITHOUT_MODEL = ("slow_no_model", "slow_empty_model", "slow_late_model")
NEXT_SCAN = "When one inference has ended, whatever came of it, the next scan is a new start."


@check(points=5, asks=WIRING, task=2, scenarios=(LEADER,), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    wired(runs)


@check(points=10, asks=TIMING, task=2, scenarios=(LEADER, FAST, TOO_SLOW), hint="2.1")
def test_control_period(runs: Runs) -> None:
    """A command every 50 ms (no gap over 75 ms), whether the model takes 200, 30 or 800 ms."""
    keeps_period(runs)


@check(points=5, asks=SAFETY, task=4, scenarios=("slow_late_lidar",), hint="4.3")
def test_starts_at_zero(runs: Runs) -> None:
    """From the first tick on there are commands; they are 0.0 until there is a prediction."""
    stands(runs, "start", help="No prediction yet is like no prediction: 0.0.")
    heeds(runs, "soon", help="Does inference still wait when no scan has come for 38 s?")


@check(points=10, asks=TIMING, task=3, scenarios=(LEADER, FAST), hint="3.1")
def test_inference_rate(runs: Runs) -> None:
    """Inference keeps going: at least 3 new predictions per second reach /cmd_vel."""
    help = "Where does a scan wait before the model sees it, and a result before control does?"
    heeds(runs, "rate", help=help)


@check(points=5, asks=TIMING, task=3, scenarios=(LEADER, FAST, LONELY), hint="3.1")
def test_scan_age(runs: Runs) -> None:
    """The scan behind a command is at most 0.58 s old (p95): scans never queue up or get lost."""
    help = "A full queue keeps what is old: let it drop that, and keep the newest."
    heeds(runs.only(LEADER, FAST), "age", help=help)
    heeds(runs, "newest", help=help)
    heeds(runs, "idle", help=NEXT_SCAN)


@check(points=5, asks=TIMING, task=3, scenarios=(SLOW_LIDAR,), hint="3.1")
def test_slow_lidar(runs: Runs) -> None:
    """With a lidar of 5 Hz: at least 2.4 new predictions per second, scans at most 0.6 s old."""
    heeds(runs, "rate", "age", help=f"{NEXT_SCAN} Does a prediction count until its scan is old?")


@check(points=10, asks=SAFETY, task=4, scenarios=(DROPOUT, LATE_SCANS), hint="4.1")
def test_too_old(runs: Runs) -> None:
    """When the lidar falls silent, the robot is told to stop within 0.65 s of the last scan."""
    help = (
        "The prediction counts as it is until its scan is 0.6 s old, and then it is 0.0, at each "
        "tick: keep the stamp from the scan's header with it, also if the scan comes late."
    )
    heeds(runs, "soon", help=NEXT_SCAN)  # a node that never asks may stand, and shows nothing
    for recording in runs:
        last, back = silence(recording)
        stands(runs.of([recording]), "silent", last + LATEST_STOP, back, help=help)


@check(points=5, asks=STATE, task=4, scenarios=(DROPOUT, TOO_SLOW, STAMPS), hint="4.1")
def test_recovery(runs: Runs) -> None:
    """When the lidar comes back, or its clock, or the model is fast again, so do predictions."""
    heeds(runs.only(DROPOUT), "back", help="Don't remember “too old”: decide again at each tick.")
    heeds(runs.only(TOO_SLOW), "idle", help="A model that was slow may be fast again: go on.")
    heeds(runs.only(STAMPS), "tick", "idle", help="The newest scan is the one that came last.")


@check(points=5, asks=DECISION, task=4, scenarios=("slow_features",))
def test_features(runs: Runs) -> None:
    """The model gets the five features of exercise 2, in their order."""
    help = "Front min, mean, std within ±60°, then the minimum to the left, then to the right."
    follows(runs, "tick", "known", "soon", help=help, tolerance=TOLERANCE)
    loads_once(runs)


@check(points=2, asks=SAFETY, task=4, scenarios=(BLIND,))
def test_blind_sector(runs: Runs) -> None:
    """A sector without a usable reading: 0.0, until a scan has features again."""
    help = f"Don't ask the model about such a scan; within 0.6 s it means 0.0. {NEXT_SCAN}"
    heeds(runs, "tick", "soon", help=help)


@check(points=5, asks=SAFETY, task=4, scenarios=(HELD, *CLIP))
def test_clipped(runs: Runs) -> None:
    """Predictions are clipped to 0 … max_speed (0.0, 0.8 m/s, or not set); the rest is 0."""
    stands(runs.only(HELD), help="max(0.0, min(max_speed, prediction)); in Python 0.0 is false.")
    heeds(runs.only(*CLIP), "tick", "soon", help="max(0.0, min(max_speed, prediction)): no ramp.")
    only_linear_x(runs)


@check(points=5, asks=SAFETY, task=3, scenarios=(RAISES,), hint="3.3")
def test_raising_model(runs: Runs) -> None:
    """A model that raises leaves the control loop running: 0.0, until it works again."""
    heeds(
        runs,
        "tick",
        "soon",
        help=f"No prediction means 0.0, after 0.6 s at the latest. {NEXT_SCAN}",
    )
    loads_once(runs)


@check(points=3, asks=SAFETY, task=3, scenarios=(NOT_FINITE,), hint="3.4")
def test_nan_model(runs: Runs) -> None:
    """NaN or ±inf from the model: 0.0, until there is a prediction again."""
    help = f"NaN and ±inf are no prediction: 0.0 within 0.6 s. {NEXT_SCAN}"
    heeds(runs, "tick", "soon", help=help)


@check(points=10, asks=TIMING, task=3, scenarios=(LONELY, RAISES, TOO_SLOW), hint="3.2")
def test_one_at_a_time(runs: Runs) -> None:
    """One inference at a time: predict is never called while another call of it still runs."""
    help = "A MutuallyExclusiveCallbackGroup, or a single worker thread, ensures that."
    heeds(runs, "alone", help=help)


@check(points=5, asks=SAFETY, task=4, scenarios=(TOO_SLOW,), hint="4.1")
def test_too_slow_model(runs: Runs) -> None:
    """A model that takes 800 ms is always too late: every command is 0.0.

    When one takes 2 s for once, what it said before is too old before it has answered.
    """
    help = "Its predictions are too old when they come: how old is the scan behind them by then?"
    heeds(runs, "zero", "known", help=help)


@check(points=10, asks=SAFETY, task=4, scenarios=(LEADER, *WITHOUT_MODEL), hint="4.3")
def test_no_model(runs: Runs) -> None:
    """Without a model that can be loaded: an error in the log, and 0.0 at each tick."""
    heeds(runs.only(LEADER), "soon", help=NEXT_SCAN)
    reacts(list(runs.only(LEADER).cases("tick")))
    bare = runs.only(*WITHOUT_MODEL)
    stands(bare, help="Without a model there is no prediction: an error in the log, and 0.0.")
    for recording in bare:
        logs(recording, ERRORS, what="the node has no model", help=SILENTLY)
