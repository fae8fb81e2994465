"""The core checks of exercise 5; they sum to 100 points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grader.checks.commands import FIELDS, ZERO, is_zero, require_zero
from grader.checks.inferences import (
    require_kept,
    require_one_at_a_time,
    require_one_load,
)
from grader.checks.model_commands import require_error_log
from grader.checks.verdict import fail
from grader.checks.wiring import require_wiring
from grader.exercises.slow_model.asking import (
    require_newest,
    require_no_idling,
    require_no_pause_after_failures,
)
from grader.exercises.slow_model.contract import (
    AGE_P95,
    AGE_P95_5_HZ,
    LATEST_STOP,
    LEAST_RATE,
    LEAST_RATE_5_HZ,
    MAX_AGE,
)
from grader.exercises.slow_model.evidence import (
    RATE_FIRST,
    STANDING,
    START_UP,
    ages,
    behind,
    holds,
    require_ages,
    require_commands,
    require_held,
    require_holds,
    require_moves,
    require_no_strays,
    require_period,
    require_rate,
    spell,
)
from grader.exercises.slow_model.late import (
    FEATURES,
    is_late,
    require_answers,
    require_right_answers,
    require_right_though_late,
)
from grader.recording import Recording

LEADER = "slow_leader"
ALONE = "slow_alone"
TOO_SLOW = "slow_too_slow"  # and fast in the end
SHORTEST_INFERENCE = 0.2  # [s] of the late lidar's model
JUDGED = 0.45  # [s] after a scan in which two inferences have passed, and a tick
AS_IT_IS = "Publish a prediction as it is, from the first tick to the last: no ramp, no filter."
LATE_SCANS = "Scans that come late count, too: one is of use until it is 0.6 s old."
AGE_HAIR = 0.05  # [s] ages this near to the limit may fall on either side

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=(LEADER,))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    for recording in recordings:
        require_wiring(recording, "slow_model")


@pytest.mark.check(points=10, scenarios=(LEADER, "slow_fast_model", TOO_SLOW), needs=("wiring",))
def test_control_period(recordings: Recordings) -> None:
    """A command every 50 ms (no gap over 75 ms), whether the model takes 200, 30 or 800 ms."""
    for recording in recordings:
        require_period(recording)


@pytest.mark.check(points=5, scenarios=("slow_late_lidar",), needs=("wiring",))
def test_starts_at_zero(recordings: Recordings) -> None:
    """From the first tick on there are commands; they are 0.0 until there is a prediction."""
    for recording in recordings:
        require_moves(recording, "Does inference still wait when no scan has come for 38 s?")
        twists, first_scan = recording.twists(), recording.scans()[0].t
        if twists.t[0] > START_UP + recording.slack:
            fail(
                "the first command came late",
                expected="a command every 50 ms from the first tick on, 0.0 at first",
                actual=f"the first one at {twists.t[0]:.2f} s",
                at=float(twists.t[0]),
                recording=recording,
                help="Publish at each tick; without a prediction, publish 0.0.",
            )
        early = np.flatnonzero(
            (twists.t < first_scan + SHORTEST_INFERENCE - ZERO) & ~is_zero(twists.linear_x)
        )
        if len(early):
            fail(
                "the robot was told to drive before there was any prediction",
                expected=f"0.0 until the first scan (at {first_scan:.2f} s) has been judged",
                actual=f"linear.x = {spell(float(twists.linear_x[early[0]]))}",
                at=float(twists.t[early[0]]),
                recording=recording,
                help="No prediction yet is like no prediction at all: 0.0.",
            )


@pytest.mark.check(points=10, scenarios=(LEADER, "slow_fast_model"), needs=("wiring",))
def test_inference_rate(recordings: Recordings) -> None:
    """Inference keeps going: at least 3 new predictions per second reach /cmd_vel."""
    for recording in recordings:
        require_rate(recording, LEAST_RATE)


@pytest.mark.check(
    points=5, scenarios=(LEADER, "slow_fast_model", ALONE), needs=("inference_rate",)
)
def test_scan_age(recordings: Recordings) -> None:
    """The scan behind a command is at most 0.58 s old (p95): scans never queue up or get lost."""
    *plain, alone = recordings
    for recording in plain:
        require_ages(recording, AGE_P95)
        require_newest(recording)
    require_newest(alone)
    require_no_idling(alone)


@pytest.mark.check(points=5, scenarios=(LEADER, "slow_lidar_5_hz"), needs=("wiring",))
def test_slow_lidar(recordings: Recordings) -> None:
    """With a lidar of 5 Hz: at least 2.4 new predictions per second, scans at most 0.6 s old."""
    leader, recording = recordings
    if is_late(leader):
        require_answers(recording, LEAST_RATE_5_HZ)
    else:
        require_rate(recording, LEAST_RATE_5_HZ)
        require_ages(recording, AGE_P95_5_HZ)


@pytest.mark.check(points=10, scenarios=("slow_dropout", "slow_late_scans"), needs=("wiring",))
def test_too_old(recordings: Recordings) -> None:
    """When the lidar falls silent, the robot is told to stop within 0.65 s of the last scan."""
    for recording in recordings:
        late = recording.scenario.faults.scan_latency > 0
        require_moves(recording, LATE_SCANS if late else RATE_FIRST)
        last, back = _dropout(recording)
        twists = recording.twists()
        latest = last + LATEST_STOP + recording.slack
        during = np.flatnonzero((twists.t > latest) & (twists.t < back))
        if len(during) < 4:
            fail(
                "the node falls silent with its lidar",
                expected="0.0 at each tick while the newest prediction is too old",
                actual=f"{len(during)} commands in {back - last - LATEST_STOP:.1f} s",
                at=last + LATEST_STOP,
                recording=recording,
                help="A robot that hears nothing drives on for a while: publish 0.0.",
            )
        moving = during[~is_zero(twists.linear_x[during])]
        if len(moving):
            i = int(moving[0])
            fail(
                f"the robot drives on what it saw {twists.t[i] - last:.2f} s ago",
                expected=f"0.0 when the scan behind the prediction is older than {MAX_AGE} s",
                actual=f"linear.x = {spell(float(twists.linear_x[i]))}",
                at=float(twists.t[i]),
                recording=recording,
                help="Keep the stamp from the scan's header with its prediction: how old is it?",
            )
        if not late:  # else it has hardly time to be judged
            _require_not_too_soon(recording, last)


@pytest.mark.check(
    points=5, scenarios=(LEADER, "slow_dropout", TOO_SLOW, "slow_stamps"), needs=("wiring",)
)
def test_recovery(recordings: Recordings) -> None:
    """When the lidar comes back, or its clock, or the model is fast again, so do predictions."""
    leader, recording, slow, stamps = recordings
    late = is_late(leader)
    require_moves(recording)
    _, back = _dropout(recording)
    twists, scans = recording.twists(), behind(recording)
    after = twists.t > back + LATEST_STOP
    without = (scans < 0 if late else ages(recording, scans) > LATEST_STOP)[after]
    most = 0.95 if late else 0.05
    if not len(without) or without.mean() > most:
        fail(
            "the node does not recover from a lidar dropout",
            expected=f"predictions again within {LATEST_STOP} s of the first new scan",
            actual=f"{int(without.sum())} of {len(without)} commands without one",
            at=back + LATEST_STOP,
            recording=recording,
            help="Don't remember “too old”: decide again at each tick.",
        )
    if not late:
        require_held(slow, "good", "A model that was slow for a while may be fast again: go on.")
        require_held(stamps, "stamps", "The newest scan is the one that came last.")


@pytest.mark.check(points=5, scenarios=(LEADER, "slow_features"), needs=("wiring",))
def test_features(recordings: Recordings) -> None:
    """The model gets the five features of exercise 2, in their order."""
    leader, bench = recordings
    if is_late(leader):
        require_right_answers(bench)
    else:
        require_held(bench, "features", FEATURES)
    require_one_load(bench, bench.duration_s)


@pytest.mark.check(
    points=5,
    scenarios=(LEADER, "slow_held", "slow_clip", "slow_default_speed"),
    needs=("wiring",),
)
def test_clipped(recordings: Recordings) -> None:
    """Predictions are clipped to 0 … max_speed (0.0, 0.8 m/s, or not set); the rest is 0."""
    leader, held, *benches = recordings
    late = is_late(leader)
    for bench in benches:
        if late:
            require_right_though_late(bench)
        else:
            require_held(bench, "clip", "max(0.0, min(max_speed, prediction))")
            require_no_strays(bench, behind(bench), help=AS_IT_IS)
        require_zero(bench, FIELDS[1:], "This robot only drives straight ahead.")
    require_holds(held)


@pytest.mark.check(points=5, scenarios=(LEADER, "slow_raises"), needs=("wiring",))
def test_raising_model(recordings: Recordings) -> None:
    """A model that raises leaves the control loop running: 0.0, until it works again."""
    leader, bench = recordings
    require_kept(bench)
    if is_late(leader):
        require_right_though_late(bench)
    else:
        require_held(bench, "raises", "No prediction means 0.0, after 0.6 s at the latest.")
        require_held(bench, "good", "After an exception the next inference counts again.")
        require_no_pause_after_failures(bench)


@pytest.mark.check(points=5, scenarios=(LEADER, "slow_nan", "slow_blind"), needs=("wiring",))
def test_nan_model(recordings: Recordings) -> None:
    """NaN or ±inf from the model, or a blind sector: 0.0, until there is a prediction again."""
    leader, silent, blind = recordings
    if is_late(leader):
        require_right_though_late(silent)
        require_right_though_late(blind)
        return
    require_held(silent, "nan", "NaN is no prediction: 0.0, after 0.6 s at the latest.")
    require_held(silent, "infinite", "Infinity is no prediction either: math.isfinite.")
    require_held(silent, "good", "After a NaN the next prediction counts again.")
    require_held(
        blind,
        "none",
        "A sector without a usable reading: no prediction, or the last one until its scan is old.",
    )
    require_held(blind, "good", "After blindness the next prediction counts again.")


@pytest.mark.check(points=10, scenarios=(ALONE, "slow_raises", TOO_SLOW), needs=("wiring",))
def test_one_at_a_time(recordings: Recordings) -> None:
    """One inference at a time: predict is never called while another call of it still runs."""
    require_moves(recordings[0])
    for recording in recordings:
        require_one_at_a_time(recording)


@pytest.mark.check(points=5, scenarios=(LEADER, TOO_SLOW), needs=("wiring",))
def test_too_slow_model(recordings: Recordings) -> None:
    """A model that takes 800 ms is always too late: every command is 0.0.

    When one takes 2 s for once, what it said before is too old before it has answered.
    """
    leader, slow = recordings
    require_moves(leader)
    fast = next((begin for _, tags, begin, *_ in holds(slow) if "slow" not in tags), math.inf)
    help = "Its predictions are 0.8 s old when they come: too old to use."
    _require_only_zeros(slow, help, until=fast)
    hangs = (begin for _, tags, begin, *_ in holds(slow) if "hangs" in tags)
    _require_only_zeros(
        slow,
        "While it takes 2 s, its last prediction grows older: how old is the scan behind it now?",
        since=next(hangs, math.inf) + LATEST_STOP + slow.slack,
    )


@pytest.mark.check(
    points=10,
    scenarios=(LEADER, "slow_no_model", "slow_empty_model", "slow_late_model"),
    needs=("wiring",),
)
def test_no_model(recordings: Recordings) -> None:
    """Without a model that can be loaded: an error in the log, and 0.0 at each tick."""
    leader, *without = recordings
    require_moves(leader)
    for bare in without:
        _require_only_zeros(
            bare, "Without a model there is no prediction: an error in the log, and 0.0."
        )
        require_error_log(bare, "the node has no model, and its log does not say so")


def _require_only_zeros(
    recording: Recording, help: str, *, since: float = 0.0, until: float = math.inf
) -> None:
    require_commands(recording)
    twists = recording.twists()
    judged = (twists.t >= since) & (twists.t < until)
    moving = np.flatnonzero(~is_zero(twists.linear_x) & judged)
    if len(moving):
        fail(
            "the robot was told to drive, though no prediction was usable",
            expected="0.0 at each tick",
            actual=f"linear.x = {spell(float(twists.linear_x[moving[0]]))}",
            at=float(twists.t[moving[0]]),
            recording=recording,
            help=help,
        )


def _require_not_too_soon(recording: Recording, last: float) -> None:
    """Fail if the prediction for the last scan [s] is not published as it is until it is too old.

    A model of 200 ms has judged that scan when two inferences have passed.
    """
    begin, end = last + JUDGED + recording.slack, last + MAX_AGE - AGE_HAIR - recording.slack
    twists = recording.twists()
    judged = (twists.t > begin) & (twists.t < end)
    scans = np.where(judged, behind(recording), STANDING)
    require_no_strays(recording, scans, 0.0, AS_IT_IS)
    standing = np.flatnonzero(judged & is_zero(twists.linear_x))
    if len(standing):
        i = int(standing[0])
        fail(
            f"the robot is told to stop {twists.t[i] - last:.2f} s after the last scan",
            expected=f"its prediction until the scan is {MAX_AGE} s old",
            actual="0.0",
            at=float(twists.t[i]),
            recording=recording,
            help="Was the last scan judged at all? If so: too old is more than 0.6 s.",
        )


def _dropout(recording: Recording) -> tuple[float, float]:
    """Return the stamp of the last scan before the dropout, and when the next one came [s].

    If none comes any more, that is the end.
    """
    t = np.append(recording.times("/scan"), recording.duration_s)
    if len(t) < 2 or np.diff(t).max() < 1.0:
        fail("the scenario ended before the lidar fell silent and came back", recording=recording)
    i = int(np.argmax(np.diff(t)))
    return recording.scans()[i].stamp, float(t[i + 1])
