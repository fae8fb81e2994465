"""The core checks of exercise 4; they sum to 100 points."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, WIRING, check
from grader.checks.verbs import (
    answers_once,
    follows,
    keeps_distance,
    only_linear_x,
    require_allowed,
    wired,
)
from grader.exercises.trend_memory.contract import TOPIC

NEAR, LATE = "trend_near", "trend_late_near"
APPROACH, AWAY, REST, RUSH = "trend_approach", "trend_recede", "trend_rest", "trend_rush"
CHANGES, STAMPS, EQUAL = "trend_changes", "trend_stamps", "trend_equal"
IN_TIME, FAST, UNUSABLE = "trend_in_time", "trend_fast", "trend_unusable"
PACES = (APPROACH, AWAY, REST, CHANGES, "trend_quick", "trend_seldom")
FREE = (NEAR, IN_TIME, AWAY, REST, LATE, UNUSABLE)
DRIVES = ("trend_wall", "trend_cart")


@check(points=5, asks=WIRING, task=1, scenarios=(NEAR,), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /closing_speed and /cmd_vel."""
    wired(runs)


@check(points=5, asks=DECISION, task=4, scenarios=(APPROACH, LATE, *DRIVES), hint="4.3")
def test_one_command_per_scan(runs: Runs) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    answers_once(runs)


@check(points=5, asks=SAFETY, task=4, scenarios=(APPROACH, IN_TIME))
def test_only_linear_x(runs: Runs) -> None:
    """Every field of the Twist but linear.x is zero."""
    only_linear_x(runs)


@check(points=5, asks=STATE, task=3, scenarios=(APPROACH, CHANGES), hint="3.4")
def test_silent_until_ten(runs: Runs) -> None:
    """Nothing on /closing_speed before the tenth reading; then closing speeds come."""
    help = "Return early: nothing is known yet, not even zero."
    follows(runs, "filling", topic=TOPIC, help=help)


@check(points=5, asks=STATE, task=3, scenarios=PACES, hint="3.4")
def test_one_speed_per_reading(runs: Runs) -> None:
    """From the tenth reading on, one closing speed follows each."""
    help = (
        "Publish once for each scan that is remembered, from the tenth one on. A deque(maxlen=10) "
        "never holds more than ten; and are stamps in seconds, sec + nanosec * 1e-9?"
    )
    follows(runs, "due", topic=TOPIC, help=help)


@check(points=10, asks=DECISION, task=3, scenarios=(APPROACH, AWAY, REST, RUSH), hint="3.1")
def test_closing_speed(runs: Runs) -> None:
    """It is minus the least-squares slope of distance over stamp: closer, away, at rest."""
    help = (
        "All ten readings count, not only the first and the last; distance over stamp in "
        "seconds; positive is closer. Subtract the first stamp before you square anything."
    )
    follows(runs, "tenth", topic=TOPIC, help=help)


@check(points=5, asks=DECISION, task=3, scenarios=("trend_ahead",), hint="2.4")
def test_looks_ahead(runs: Runs) -> None:
    """The distance is the smallest one within ±90° of ahead, as in exercise 1."""
    help = "Compute each beam's angle; what is behind the robot does not matter."
    follows(runs, "full", topic=TOPIC, help=help)


@check(points=5, asks=STATE, task=3, scenarios=(CHANGES, REST), hint="2.2")
def test_forgets_old(runs: Runs) -> None:
    """Only the last ten readings count: what was before is forgotten, one reading at a time."""
    help = "With each new reading the oldest one goes: deque(maxlen=10)."
    follows(runs, "full", topic=TOPIC, help=help)


@check(points=5, asks=STATE, task=3, scenarios=(STAMPS, EQUAL), hint="2.3")
def test_uses_stamps(runs: Runs) -> None:
    """Time is the scan's header stamp: scans may be late or missing, stamps may be equal."""
    help = (
        "header.stamp (sec and nanosec) says when the scan was measured; use that. A scan with "
        "the stamp of the one before is a reading, too; only a step back empties."
    )
    follows(runs, "full", topic=TOPIC, help=help)


@check(points=5, asks=STATE, task=3, scenarios=(UNUSABLE,), hint="2.4")
def test_unusable_scans(runs: Runs) -> None:
    """Scans without a usable distance ahead, or with +inf, are not remembered."""
    help = (
        "A scan that is blind, or +inf ahead, neither adds a reading nor takes one away, and "
        "nothing is published for it. -inf is distance 0: a reading like any other."
    )
    follows(runs, "due", "not_due", topic=TOPIC, help=help)
    follows(runs, "full", topic=TOPIC, help=help)


@check(points=5, asks=STATE, task=5, scenarios=("trend_backwards",), hint="5.1")
def test_clears_backwards(runs: Runs) -> None:
    """A stamp that goes backwards empties the memory first; then ten new readings are needed."""
    starts_over(runs)


@check(points=5, asks=STATE, task=5, scenarios=("trend_jump",), hint="5.1")
def test_clears_jump(runs: Runs) -> None:
    """A stamp that jumps ahead by more than 1 s empties the memory first; 0.96 s does not."""
    starts_over(runs)


@check(points=5, asks=SAFETY, task=4, scenarios=(NEAR, LATE, "trend_near_away"), hint="4.1")
def test_stops_near(runs: Runs) -> None:
    """Below 0.5 m the robot stands, whether or not a closing speed is known, and whatever it is."""
    follows(runs, "near", help="Below 0.5 m: 0.0 m/s, from the first scan on.")


@check(points=10, asks=SAFETY, task=4, scenarios=(IN_TIME, FAST, RUSH, UNUSABLE), hint="4.2")
def test_stops_in_time(runs: Runs) -> None:
    """The robot stands when less than 2 s are left: distance / closing speed < 2.0 s."""
    help = "Something comes: does the newest closing speed count?"
    follows(runs, "in_time", "after", help=help)


@check(points=5, asks=DECISION, task=4, scenarios=FREE, hint="4.2")
def test_drives_free(runs: Runs) -> None:
    """Otherwise it drives at 0.3 m/s: enough time, moving away, at rest, nothing in range."""
    help = (
        "Without danger it is 0.3 m/s, before the tenth reading too. A negative closing speed "
        "is no danger, and at 0.0 m/s there is nothing to divide by."
    )
    follows(runs, "free", help=help)


@check(points=5, asks=SAFETY, task=4, scenarios=("trend_blind",), hint="4.1")
def test_blind(runs: Runs) -> None:
    """Without any usable reading ahead the robot stands, and it drives on when it sees again."""
    follows(runs, "blind", help="No usable reading: the robot cannot know, so 0.0.")
    follows(runs, "seen", help="After blindness a good scan counts again.")


@check(points=10, asks=SAFETY, scenarios=DRIVES)
def test_no_contact(runs: Runs) -> None:
    """Before a wall and a cart that comes closer the robot keeps a clearance of 0.2 m."""
    help = "Watch the replay from two seconds before: what was the closing speed?"
    keeps_distance(runs, help=help)


def starts_over(runs: Runs) -> None:
    """Fail unless the memory is emptied, and decides nothing until it is full again."""
    help = "Compare each stamp with the one before; clear, then remember the new one."
    follows(runs, "pace", topic=TOPIC, help=help)
    for recording, case in runs.cases("forgotten"):
        require_allowed(recording, case, "With the memory goes the closing speed: wait for ten.")
