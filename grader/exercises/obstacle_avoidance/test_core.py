"""The core checks of exercise 1; they sum to 100 points."""

from __future__ import annotations

from grader.checks.callbacks import quick, stays_quick
from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, TIMING, WIRING, check
from grader.checks.verbs import (
    answers_once,
    drives_on,
    follows,
    keeps_distance,
    only_linear_x,
    wired,
)
from grader.exercises.obstacle_avoidance.contract import CLEARANCE, FREE

HUNDRED = "avoid_hundred"
LONG = "avoid_long"  # and sixteen seconds without a scan
PACE = ("wiring", "one_command_per_scan")
BENCH = ("avoid_zones", "avoid_infinity", "avoid_invalid", "avoid_too_close", "avoid_blind")
DRIVES = (
    "avoid_wall", "avoid_box_behind", "avoid_corridor", "avoid_cart", "avoid_store", "avoid_post",
)  # fmt: skip
CALLBACK_LIMIT = 0.1  # [s], p99


@check(points=5, asks=WIRING, task=1, scenarios=("avoid_zones",), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    wired(runs)


@check(
    points=5, asks=DECISION, task=2, scenarios=("avoid_zones", HUNDRED, LONG, *DRIVES), hint="2.1"
)
def test_one_command_per_scan(runs: Runs) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    answers_once(runs)


@check(points=5, asks=SAFETY, task=2, scenarios=("avoid_zones", "avoid_wall", LONG), hint="2.1")
def test_only_linear_x(runs: Runs) -> None:
    """Every field of the Twist but linear.x is zero."""
    only_linear_x(runs)


@check(points=10, asks=DECISION, task=4, scenarios=("avoid_zones", HUNDRED), hint="4.2")
def test_clear_zone(runs: Runs) -> None:
    """From 1.0 m on the robot drives at 0.50 m/s."""
    follows(runs, "clear", help="From 1.0 m on, 1.0 m itself too, and after a stop as before it.")


@check(points=10, asks=DECISION, task=4, scenarios=("avoid_zones",), hint="4.2")
def test_slow_zone(runs: Runs) -> None:
    """From 0.5 m to below 1.0 m the robot drives at 0.15 m/s."""
    follows(runs, "slow", help="From 0.5 m itself to below 1.0 m, of the smallest distance ahead.")


@check(points=10, asks=SAFETY, task=4, scenarios=("avoid_zones", HUNDRED, LONG), hint="4.2")
def test_stop_zone(runs: Runs) -> None:
    """Below 0.5 m the robot stands still, for however long."""
    help = "Is d the smallest distance within ±90°, and is every d below 0.5 m a stop?"
    follows(runs, "stop", help=help)


@check(points=5, asks=DECISION, task=3, scenarios=("avoid_zones",), hint="3.1")
def test_ignores_behind(runs: Runs) -> None:
    """What is behind the robot (beyond ±90°) does not matter."""
    follows(runs, "behind", help="Only beams within ±90° (±π/2 rad) of ahead count.")


@check(points=10, asks=DECISION, task=3, scenarios=("avoid_zones",), hint="3.1")
def test_sees_sides(runs: Runs) -> None:
    """Whatever is ahead counts, be it small or far to one side (up to ±90°)."""
    help = "A single beam is enough. Compare angle_min + i · angle_increment with ±π/2."
    follows(runs, "side", "ahead", help=help)


@check(points=3, asks=DECISION, task=3, scenarios=("avoid_infinity",), hint="3.4")
def test_infinite_readings(runs: Runs) -> None:
    """+inf means that nothing is within range: the way is free."""
    follows(runs, "infinite", help="Do not throw +inf away: it is a distance, a big one.")


@check(points=10, asks=DECISION, task=3, scenarios=("avoid_invalid",), hint="3.3")
def test_invalid_readings(runs: Runs) -> None:
    """NaN, and finite readings outside range_min … range_max, are ignored; the others count."""
    follows(runs, "nan", help="Drop NaN: every comparison with it is false.")
    help = "range_min and range_max themselves are distances; what lies beyond them is none."
    follows(runs, "limits", help=help)


@check(points=2, asks=SAFETY, task=3, scenarios=("avoid_too_close",), hint="3.4")
def test_minus_infinity(runs: Runs) -> None:
    """-inf means closer than the sensor can measure: distance 0."""
    follows(runs, "minus_infinity", help="-inf is not free: it is as near as can be.")


@check(points=5, asks=SAFETY, task=3, scenarios=("avoid_blind",), hint="3.5")
def test_blind(runs: Runs) -> None:
    """Without any usable reading ahead the robot stands, and it drives on when it sees again."""
    follows(runs, "blind", help="No usable reading: the robot cannot know, so 0.0.")
    follows(runs, "lives_on", help="After blindness a good scan counts again.")


@check(
    points=10,
    asks=SAFETY,
    scenarios=DRIVES,
    needs=("wiring", "one_command_per_scan", "stop_zone"),
    hint="4.2",
)
def test_no_contact(runs: Runs) -> None:
    """In six worlds the robot touches nothing and keeps a clearance of 0.2 m."""
    keeps_distance(runs, CLEARANCE, "Stop as soon as the nearest reading ahead is below 0.5 m.")


@check(points=5, asks=STATE, scenarios=(HUNDRED, LONG, *DRIVES), hint="4.1")
def test_drives_on(runs: Runs) -> None:
    """The robot drives whenever the way ahead is free, also after a stop, and a long one."""
    drives_on(runs.only(*DRIVES), FREE)
    help = "Each scan decides for itself, whatever came before and whatever its stamp is."
    follows(runs.only(HUNDRED), "after_stop", help=help)
    follows(runs.only(LONG), "slow", "free", help=help)


@check(points=5, asks=TIMING, scenarios=(*BENCH, *DRIVES, LONG), needs=PACE)
def test_callback_time(runs: Runs) -> None:
    """A scan is dealt with in 100 ms, at least 99 times in 100, and after an hour, too."""
    quick(runs, CALLBACK_LIMIT)
    stays_quick(runs, CALLBACK_LIMIT)
