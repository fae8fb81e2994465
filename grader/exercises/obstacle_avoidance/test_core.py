"""The core checks of exercise 1; they sum to 100 points."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checks.commands import judged, require_one_command_each, require_only_linear_x
from grader.checks.driving import path_length
from grader.checks.moments import came_to_rest
from grader.checks.turns import answered_in_turn, until_next_scan
from grader.checks.verdict import fail, inconclusive, passes
from grader.checks.wiring import require_wiring
from grader.exercises.obstacle_avoidance.evidence import (
    own_speeds,
    require_caution,
    require_distance,
    require_moving_when_free,
    require_speed,
    require_speeds,
)
from grader.recording import Recording

HUNDRED = "avoid_hundred"
LONG = "avoid_long"  # and sixteen seconds without a scan
BENCH = ("avoid_zones", "avoid_infinity", "avoid_invalid", "avoid_too_close", "avoid_blind")
DRIVES = (
    "avoid_wall", "avoid_box_behind", "avoid_corridor", "avoid_cart", "avoid_store", "avoid_post",
)  # fmt: skip
CALLBACK_LIMIT = 0.1  # [s], p99
OFTEN = 90  # [%] stalls of a machine don't hit one callback in ten, unless threads queue for it
LEAST_WAY = 0.5  # [m] driven in at least one of the worlds

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=("avoid_zones",))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    for recording in recordings:
        require_wiring(recording, "obstacle_avoidance")


@pytest.mark.check(points=5, scenarios=("avoid_zones", HUNDRED, LONG, *DRIVES), needs=("wiring",))
def test_one_command_per_scan(recordings: Recordings) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    for recording in recordings:
        require_one_command_each(recording)


@pytest.mark.check(points=5, scenarios=("avoid_zones", "avoid_wall", LONG), needs=("wiring",))
def test_only_linear_x(recordings: Recordings) -> None:
    """Every field of the Twist but linear.x is zero."""
    for recording in recordings:
        require_only_linear_x(recording, "This agent only drives straight ahead.")


@pytest.mark.check(points=10, scenarios=("avoid_zones", HUNDRED), needs=("wiring",))
def test_clear_zone(recordings: Recordings) -> None:
    """From 1.0 m on the robot drives at 0.50 m/s."""
    for recording in recordings:
        require_speeds(recording, "clear", "1.0 m itself belongs to the clear zone.")


@pytest.mark.check(points=10, scenarios=("avoid_zones",), needs=("wiring",))
def test_slow_zone(recordings: Recordings) -> None:
    """From 0.5 m to below 1.0 m the robot drives at 0.15 m/s."""
    for recording in recordings:
        require_speeds(
            recording, "slow", "0.5 m itself belongs to the slow zone; 30 % of 0.5 m/s is 0.15."
        )


@pytest.mark.check(points=10, scenarios=("avoid_zones", HUNDRED, LONG), needs=("wiring",))
def test_stop_zone(recordings: Recordings) -> None:
    """Below 0.5 m the robot stands still, for however long."""
    zones, *others = recordings
    help = "Is d the smallest distance within ±90°, and is every d below 0.5 m a stop?"
    require_speeds(zones, "stop", help)
    for recording in others:
        for answer in judged(recording, "stop"):
            if answer.count:
                require_speed(recording, answer, help)


@pytest.mark.check(points=5, scenarios=("avoid_zones",), needs=("wiring",))
def test_ignores_behind(recordings: Recordings) -> None:
    """What is behind the robot (beyond ±90°) does not matter."""
    (zones,) = recordings
    help = "Only beams within ±90° (±π/2 rad) of ahead count."
    require_speeds(zones, "behind", help, own=own_speeds(zones))


@pytest.mark.check(points=10, scenarios=("avoid_zones",), needs=("wiring",))
def test_sees_sides(recordings: Recordings) -> None:
    """Whatever is ahead counts, be it small or far to one side (up to ±90°)."""
    (zones,) = recordings
    for tag in ("side", "ahead"):
        require_speeds(
            zones,
            tag,
            "All beams within ±90° count, to the left and to the right, and a single one is "
            "enough: compare each beam's angle, angle_min + i · angle_increment, with ±π/2.",
            own=own_speeds(zones),
        )


@pytest.mark.check(points=5, scenarios=("avoid_zones", "avoid_infinity"), needs=("wiring",))
def test_infinite_readings(recordings: Recordings) -> None:
    """+inf means that nothing is within range: the way is free."""
    zones, infinity = recordings
    help = "Do not throw +inf away: it is a distance, a big one."
    require_speeds(infinity, "infinite", help, own=own_speeds(zones))


@pytest.mark.check(points=5, scenarios=("avoid_zones", "avoid_invalid"), needs=("wiring",))
def test_invalid_readings(recordings: Recordings) -> None:
    """NaN, and finite readings outside range_min … range_max, are ignored; the others count."""
    zones, invalid = recordings
    require_speeds(
        invalid,
        "invalid",
        "Drop NaN (every comparison with it is false) and what is outside the limits; "
        "then decide on the rest.",
        own=own_speeds(zones),
    )


@pytest.mark.check(points=5, scenarios=("avoid_zones", "avoid_too_close"), needs=("wiring",))
def test_minus_infinity(recordings: Recordings) -> None:
    """-inf means closer than the sensor can measure: distance 0."""
    zones, too_close = recordings
    help = "-inf is not free: it is as near as can be."
    require_speeds(too_close, "minus_infinity", help, own=own_speeds(zones))


@pytest.mark.check(points=5, scenarios=("avoid_zones", "avoid_blind"), needs=("wiring",))
def test_blind(recordings: Recordings) -> None:
    """Without any usable reading ahead the robot stands, and it drives on when it sees again."""
    zones, blind = recordings
    own = own_speeds(zones)
    require_speeds(blind, "blind", "No usable reading: the robot cannot know, so 0.0.", own=own)
    require_speeds(blind, "lives_on", "After blindness a good scan counts again.", own=own)


@pytest.mark.check(points=10, scenarios=DRIVES, needs=("wiring", "one_command_per_scan"))
def test_no_contact(recordings: Recordings) -> None:
    """In six worlds the robot touches nothing and keeps a clearance of 0.2 m."""
    for recording in recordings:
        require_distance(recording)
    if max(map(path_length, recordings)) < LEAST_WAY:
        fail(
            "the robot never moved, so this proves nothing",
            expected="a robot that drives where the way is free",
            actual=f"less than {LEAST_WAY} m driven in each of the worlds",
            at=came_to_rest(recordings[0]),
            recording=recordings[0],
            help="Get clear_zone and drives_on right first.",
        )
    require_caution(recordings)


@pytest.mark.check(points=5, scenarios=("avoid_zones", HUNDRED, LONG, *DRIVES), needs=("wiring",))
def test_drives_on(recordings: Recordings) -> None:
    """The robot drives whenever the way ahead is free, also after a stop, and a long one."""
    zones, hundred, long, *drives = recordings
    for recording in drives:
        require_moving_when_free(recording)
    require_speeds(
        hundred,
        "after_stop",
        "Each scan decides for itself: 0.5 m is the limit after a stop, too.",
        own=own_speeds(zones),
    )
    if not passes(require_speeds, hundred, "clear"):  # which is for clear_zone to say
        return
    help = "Each scan decides for itself, whatever came before and whatever its stamp is."
    for answer in (*judged(long, "slow"), *judged(long, "free")):
        if answer.count:  # else one_command_per_scan has failed
            require_speed(long, answer, help, own_speeds(zones))


@pytest.mark.check(points=5, scenarios=(*BENCH, *DRIVES), needs=("wiring", "one_command_per_scan"))
def test_callback_time(recordings: Recordings) -> None:
    """A scan is dealt with in 100 ms, at least 99 times in 100."""
    costs = [_costs(recording) for recording in recordings]
    wall, cpu, queued = (np.concatenate(part) for part in zip(*costs, strict=True))
    if len(wall) < 200:
        fail(
            f"only {len(wall)} scans were dealt with before the node ended",
            expected="at least 200 callbacks to measure",
            actual=f"{len(wall)}",
        )
    p99 = float(np.percentile(wall, 99))
    computed, busy = np.concatenate([until_next_scan(r) for r in recordings], axis=1)
    own = _most(99, np.fmin(wall, cpu), computed)  # [s] spent computing
    often = _most(OFTEN, wall - queued, busy)  # [s] without the wait for a CPU
    if max(p99, own, often) <= CALLBACK_LIMIT:
        return
    if max(own, often) <= CALLBACK_LIMIT:
        inconclusive("the machine stalled while the callbacks were being measured")
    longest = int(np.argmax([max(run_wall, default=0.0) for run_wall, _, _ in costs]))
    fail(
        "the scan callback takes too long",
        expected=f"at most {1000 * CALLBACK_LIMIT:.0f} ms (p99)",
        actual=f"{1000 * own:.0f} ms (p99 of {len(wall)} calls)"
        if own > CALLBACK_LIMIT
        else f"at least {1000 * often:.0f} ms in {100 - OFTEN} of 100 calls, mostly spent waiting",
        at=_times(recordings[longest])[np.argmax(costs[longest][0])],
        recording=recordings[longest],
        help="At 10 Hz the next scan comes after 100 ms. What in the callback costs the time?",
    )


def _most(percent: float, *durations: np.ndarray) -> float:
    """Return the largest of the percentiles [s] of several measures."""
    return max(float(np.percentile(each, percent)) for each in durations if len(each))


def _costs(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return wall time, CPU time and the wait for a CPU [s] of each callback of a scan."""
    compute = recording.compute
    scans = recording.times("/scan")
    count = answered_in_turn(recording)
    if not count:
        with_scan = np.isin(compute.time, scans)
        return compute.wall[with_scan], compute.cpu[with_scan], compute.queued[with_scan]
    scans, answered = scans[:count], recording.twists().t
    begin = np.searchsorted(compute.time, scans)
    end = np.maximum(np.searchsorted(compute.time, answered), begin + 1)
    spans = [slice(*span) for span in zip(begin, end, strict=True)]
    cpu = np.array([compute.cpu[span].sum() for span in spans])
    queued = np.array([compute.queued[span].max(initial=0.0) for span in spans])
    return answered - scans, cpu, queued


def _times(recording: Recording) -> np.ndarray:
    """Return when the callbacks in `_costs` began [s]."""
    scans = recording.times("/scan")
    if count := answered_in_turn(recording):
        return scans[:count]
    times: np.ndarray = recording.compute.time
    return times[np.isin(times, scans)]
