"""The core checks of exercise 4; they sum to 100 points."""

from __future__ import annotations

from dataclasses import replace

import pytest

from grader.checks.commands import require_one_command_each, require_only_linear_x
from grader.checks.verdict import fail, passes
from grader.checks.wiring import require_wiring
from grader.exercises.trend_memory.contract import MEMORY_SIZE
from grader.exercises.trend_memory.evidence import (
    TOPIC,
    asked,
    cases,
    closing_speeds,
    require_distance,
    require_forgotten,
    require_memory,
    require_one,
    require_plain,
    require_rule,
    require_scans,
    require_silence,
    require_speeds,
    require_value,
    require_way,
    shown_habits,
    told_by,
)
from grader.exercises.trend_memory.habits import APPROACH, CHANGES, PLAIN, SMALL, STAMPS, in_seconds
from grader.recording import Recording

AWAY, REST, LATE = "trend_recede", "trend_rest", "trend_late_near"
RUSH, QUICK, SELDOM = "trend_rush", "trend_quick", "trend_seldom"
EQUAL, FAST, IN_TIME = "trend_equal", "trend_fast", "trend_in_time"
DRIVES = ("trend_wall", "trend_cart")
CLEAR = "Compare each stamp with the one before; clear, then remember the new one."

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=("trend_near",))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and publishes on /closing_speed and /cmd_vel."""
    for recording in recordings:
        require_wiring(recording, "trend_memory")


@pytest.mark.check(points=5, scenarios=(APPROACH, LATE, *DRIVES), needs=("wiring",))
def test_one_command_per_scan(recordings: Recordings) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    for recording in recordings:
        require_one_command_each(recording)


@pytest.mark.check(points=5, scenarios=(APPROACH, IN_TIME), needs=("wiring",))
def test_only_linear_x(recordings: Recordings) -> None:
    """Every field of the Twist but linear.x is zero."""
    for recording in recordings:
        require_only_linear_x(recording, "This agent only drives straight ahead.")


@pytest.mark.check(points=5, scenarios=(APPROACH, CHANGES), needs=("wiring",))
def test_silent_until_ten(recordings: Recordings) -> None:
    """Nothing on /closing_speed before the tenth reading; then closing speeds come."""
    for recording in recordings:
        require_scans(recording)
        times, _ = closing_speeds(recording)
        if not times:
            due = [case.step.scan.t for case in cases(recording) if case.step.spoken]
            fail(
                f"not a single message came on {TOPIC}",
                expected="a closing speed from the tenth reading on",
                actual=f"{len(recording.scans())} readings and nothing on {TOPIC}",
                at=due[0] if due else None,
                recording=recording,
                help="A deque(maxlen=10) never holds more than ten: compare with == 10 or >= 10.",
            )
        for case in cases(recording):
            require_silence(recording, case)


@pytest.mark.check(
    points=5, scenarios=(APPROACH, AWAY, REST, CHANGES, QUICK, SELDOM), needs=("wiring",)
)
def test_one_speed_per_reading(recordings: Recordings) -> None:
    """From the tenth reading on, one closing speed follows each."""
    for recording in _survived(recordings):
        require_scans(recording)
        for case in cases(recording):
            require_one(recording, case)


@pytest.mark.check(points=10, scenarios=(APPROACH, AWAY, REST, RUSH), needs=("wiring",))
def test_closing_speed(recordings: Recordings) -> None:
    """It is minus the least-squares slope of distance over stamp: closer, away, at rest."""
    silent_away = False  # which is for one_speed_per_reading to say
    for recording in recordings:
        require_scans(recording)
        tenth = next(case for case in cases(recording) if case.step.spoken)
        silent_away |= recording.name == AWAY and not tenth.said
        if not silent_away:
            require_one(recording, tenth)
        require_value(
            recording,
            tenth,
            "All ten readings count, not only the first and the last; distance over stamp in "
            "seconds; positive is closer. Subtract the first stamp before you square anything.",
        )


@pytest.mark.check(points=5, scenarios=("trend_ahead", *PLAIN), needs=("wiring",))
def test_looks_ahead(recordings: Recordings) -> None:
    """The distance is the smallest one within ±90° of ahead, as in exercise 1."""
    habits = shown_habits(recordings)
    for recording in asked(recordings):
        require_rule(recording, habits)
        require_memory(
            recording,
            habits,
            "Compute each beam's angle; what is behind the robot does not matter.",
        )


@pytest.mark.check(points=5, scenarios=(CHANGES, REST, APPROACH, SMALL), needs=("wiring",))
def test_forgets_old(recordings: Recordings) -> None:
    """Only the last ten readings count: what was before is forgotten, one reading at a time."""
    habits, judged = told_by(recordings, _survived(recordings[:2]))
    for recording in judged:
        require_plain(
            recording,
            replace(habits, law=habits.law and habits.law._replace(keeps=MEMORY_SIZE, first=False)),
            "With each new reading the oldest one goes: deque(maxlen=10).",
            after=14,
        )


@pytest.mark.check(points=5, scenarios=(STAMPS, EQUAL, CHANGES, APPROACH, SMALL), needs=("wiring",))
def test_uses_stamps(recordings: Recordings) -> None:
    """Time is the scan's header stamp: scans may be late or missing, stamps may be equal."""
    habits, (late, *equal) = told_by(recordings, recordings[:2])
    habits = replace(habits, law=habits.law and in_seconds(habits.law))
    help = "header.stamp (sec and nanosec) says when the scan was measured; use that."
    require_plain(late, habits, help)
    help = "A scan with the stamp of the one before is a reading, too; only a step back empties."
    for recording in equal:
        require_plain(recording, habits, help)


@pytest.mark.check(points=5, scenarios=("trend_unusable", IN_TIME, FAST, *PLAIN), needs=("wiring",))
def test_unusable_scans(recordings: Recordings) -> None:
    """Scans without a usable distance ahead, or with +inf, are not remembered."""
    unusable, *fast = recordings[:3]
    habits = shown_habits(recordings)
    require_memory(
        unusable,
        habits,
        "A scan that is blind, or +inf ahead, neither adds a reading nor takes one away, and "
        "nothing is published for it. -inf is distance 0: a reading like any other.",
    )
    if passes(test_stops_in_time, tuple(fast)):  # if not, that check has failed
        require_speeds(
            (unusable,),
            "after",
            "The next reading that counts has nine others before it, as if no such scan had come.",
            habits,
        )


@pytest.mark.check(points=5, scenarios=("trend_backwards", *PLAIN), needs=("wiring",))
def test_clears_backwards(recordings: Recordings) -> None:
    """A stamp that goes backwards empties the memory first; then ten new readings are needed."""
    habits = shown_habits(recordings)
    for recording in asked(recordings):
        require_memory(recording, habits, CLEAR)
        require_forgotten(recording, habits)


@pytest.mark.check(points=5, scenarios=("trend_jump", *PLAIN), needs=("wiring",))
def test_clears_jump(recordings: Recordings) -> None:
    """A stamp that jumps ahead by more than 1 s empties the memory first; 0.96 s does not."""
    habits = shown_habits(recordings)
    for recording in asked(recordings):
        require_memory(recording, habits, CLEAR)
        require_forgotten(recording, habits)


@pytest.mark.check(points=5, scenarios=("trend_near", LATE, "trend_near_away"), needs=("wiring",))
def test_stops_near(recordings: Recordings) -> None:
    """Below 0.5 m the robot stands, whether or not a closing speed is known, and whatever it is."""
    require_speeds(recordings, "near", "Below 0.5 m: 0.0 m/s, from the first scan on.")


@pytest.mark.check(points=10, scenarios=(IN_TIME, FAST, RUSH), needs=("wiring",))
def test_stops_in_time(recordings: Recordings) -> None:
    """The robot stands when less than 2 s are left: distance / closing speed < 2.0 s."""
    # By the true closing speed, not by the node's own: who is wrong about it stops too late
    require_speeds(recordings, "in_time", "Something comes: does the newest closing speed count?")


@pytest.mark.check(
    points=5,
    scenarios=("trend_near", IN_TIME, FAST, AWAY, REST, LATE, "trend_unusable", *PLAIN),
    needs=("wiring",),
)
def test_drives_free(recordings: Recordings) -> None:
    """Otherwise it drives at 0.3 m/s: enough time, moving away, at rest, nothing in range."""
    require_speeds(
        _answered(asked(recordings)),
        "free",
        "Without danger it is 0.3 m/s, before the tenth reading too. A negative closing speed "
        "is no danger, and at 0.0 m/s there is nothing to divide by.",
        shown_habits(recordings),
    )


@pytest.mark.check(points=5, scenarios=("trend_blind", *PLAIN), needs=("wiring",))
def test_blind(recordings: Recordings) -> None:
    """Without any usable reading ahead the robot stands, and it drives on when it sees again."""
    habits, there = shown_habits(recordings), asked(recordings)
    require_speeds(there, "blind", "No usable reading: the robot cannot know, so 0.0.", habits)
    require_speeds(there, "seen", "After blindness a good scan counts again.", habits)


@pytest.mark.check(points=10, scenarios=(*DRIVES, *PLAIN), needs=("wiring",))
def test_no_contact(recordings: Recordings) -> None:
    """Before a wall and a cart that comes closer the robot keeps a clearance of 0.2 m."""
    drives, habits = asked(recordings), shown_habits(recordings)
    for recording in drives:
        require_distance(recording)
    for recording in drives:
        require_way(recording, habits)


def _survived(recordings: Recordings) -> Recordings:
    """Return the recordings but that of rest, if the node died of it: that is for `drives_free`."""
    return tuple(r for r in recordings if r.name != REST or r.outcome.completed)


def _answered(recordings: Recordings) -> Recordings:
    """Return the recordings but an unanswered late one: that is for `one_command_per_scan`."""
    return tuple(r for r in recordings if r.name != LATE or passes(test_one_command_per_scan, (r,)))
