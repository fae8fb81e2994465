"""The core checks of exercise 7; they sum to 100 points."""

from __future__ import annotations

import pytest

from grader.checks.driving import path_length, require_no_contact
from grader.checks.moments import came_to_rest
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.exercises.safety_supervisor.contract import (
    is_settled,
    never_reverses,
)
from grader.exercises.safety_supervisor.evidence import (
    require_commands,
    require_e_stop,
    require_levels,
    require_moving_after,
    require_no_delay,
    require_other_fields,
    require_reasons,
    require_standing,
    require_stops,
    require_text,
    require_turning,
    require_within_limits,
    standing,
    stands,
)
from grader.exercises.safety_supervisor.habits import SHOWS, button_of, habit_of
from grader.exercises.safety_supervisor.precedence import require_first_match
from grader.exercises.safety_supervisor.rises import require_no_jumps, require_rises
from grader.exercises.safety_supervisor.timing import require_heartbeat, require_rate
from grader.recording import Recording

SHORT = (
    "safe_pass",
    "safe_limits",
    "safe_ramp",
    "safe_e_stop",
    "safe_stale_command",
    "safe_obstacle",
    "safe_stale_scan",
)  # every reason but bad_command
EVERY = (*SHORT, "safe_bad_command", "safe_blind")
BUTTON = "safe_button"  # at the same time as other reasons
LONG = "safe_for_long"  # half a minute and more
BUSY = "safe_busy"  # lidar and model at 40 Hz
LEAST_WAY = 0.5  # [m]

Recordings = tuple[Recording, ...]


def judged_to_its_end(recordings: Recordings) -> Recordings:
    """Return the first, and those of the others that the node survived: what it dies of is told."""
    return tuple(each for each in recordings if each is recordings[0] or each.outcome.completed)


@pytest.mark.check(points=5, scenarios=("safe_pass",))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to 3 topics and publishes on /cmd_vel and /diagnostics."""
    for recording in recordings:
        require_wiring(recording, "safety_supervisor")


@pytest.mark.check(points=5, scenarios=(*EVERY, LONG), needs=("wiring",))
def test_control_rate(recordings: Recordings) -> None:
    """One command at each tick, 20 a second from the start on, whatever the reason for it."""
    for recording in judged_to_its_end(recordings):
        require_rate(recording)


@pytest.mark.check(points=5, scenarios=("safe_pass", "safe_obstacle", SHOWS), needs=("wiring",))
def test_passes_on(recordings: Recordings) -> None:
    """What is safe is passed on as it is, backwards too; the four other fields are zero."""
    for recording in recordings[:1]:
        require_commands(
            recording,
            "Where no rule stops or limits it, linear.x and angular.z go out as they came in; "
            "linear.x gets there in steps of 0.045 from what was published last.",
            is_settled,
            habit=habit_of(recordings),
        )
    for recording in recordings:
        require_other_fields(recording)


@pytest.mark.check(points=5, scenarios=("safe_limits", LONG, SHOWS), needs=("wiring",))
def test_limits(recordings: Recordings) -> None:
    """linear.x is clamped to ±0.5 m/s and angular.z to ±1.9 rad/s, for however long."""
    shows, long, _ = recordings
    require_alive(shows)
    require_within_limits(shows)
    require_within_limits(long)
    require_commands(
        shows,
        "Clamp to the limit, not to zero; what is within is not touched.",
        is_settled,
        habit=habit_of(recordings),
        forgiven=lambda tick: never_reverses(tick, shows),
    )


@pytest.mark.check(
    points=10,
    scenarios=(
        "safe_ramp",
        "safe_bad_command",
        "safe_stale_command",
        "safe_stale_scan",
        "safe_blind",
        "safe_obstacle",
        "safe_limits",
        SHOWS,
    ),
    needs=("wiring",),
)
def test_acceleration(recordings: Recordings) -> None:
    """linear.x rises by at most 0.045 m/s a tick, from the last command published or from 0."""
    first, *others, _ = recordings
    habit = button_of(recordings)
    require_rises(first, habit)
    for recording in others:
        require_no_jumps(recording, habit)


@pytest.mark.check(points=5, scenarios=("safe_ramp", BUSY, SHOWS), needs=("wiring",))
def test_never_delays(recordings: Recordings) -> None:
    """Slowing down, stopping and driving backwards take effect at once."""
    ramp, busy, _ = recordings
    help, habit = (
        "The limit is for getting faster forwards only: min(asked, max(0, last) + 0.045).",
        button_of(recordings),
    )
    require_commands(
        ramp,
        help,
        lambda tick: not tick.rising and "e_stop" not in tick.reasons,
        habit=habit,
        forgiven=lambda tick: never_reverses(tick, ramp),
    )
    require_no_delay(busy, help, habit)


@pytest.mark.check(points=10, scenarios=(SHOWS, BUSY, BUTTON, LONG), needs=("wiring",))
def test_e_stop(recordings: Recordings) -> None:
    """While the last /e_stop was true the robot stands, from the next tick on."""
    shows, busy, *others = recordings
    require_e_stop(shows)
    for recording in (busy, *others):
        require_standing(
            recording,
            "e_stop",
            "Whatever else holds, or has not come yet, and for however long: the last /e_stop "
            "decides.",
        )
    require_moving_after(busy, "e_stop", "A button may be let go while the lidar is silent.")


@pytest.mark.check(points=5, scenarios=("safe_bad_command", LONG, SHOWS), needs=("wiring",))
def test_bad_command(recordings: Recordings) -> None:
    """A command with NaN or infinity in a field stops the robot until a good one comes."""
    bad, long, _ = recordings
    help, habit = (
        "math.isfinite on each field, before you compare: comparisons with NaN are false.",
        habit_of(recordings),
    )
    require_stops(bad, "bad_command", help, habit)
    require_standing(long, "bad_command", help, habit)


@pytest.mark.check(
    points=5, scenarios=("safe_stale_command", BUTTON, LONG, SHOWS), needs=("wiring",)
)
def test_stale_command(recordings: Recordings) -> None:
    """Without a raw command for more than 0.5 s (or at all) the robot stands."""
    silence, *others, _ = recordings
    help, habit = (
        "Note when each command arrives, and look at its age at every tick.",
        habit_of(recordings),
    )
    require_stops(silence, "stale_command", help, habit)
    for recording in others:
        require_standing(recording, "stale_command", help, habit)


@pytest.mark.check(points=5, scenarios=("safe_stale_scan", BUTTON, LONG, SHOWS), needs=("wiring",))
def test_stale_scan(recordings: Recordings) -> None:
    """Without a scan for more than 0.5 s (or at all) the robot stands."""
    silence, *others, _ = recordings
    help, habit = (
        "Note when each scan arrives, and look at its age at every tick.",
        habit_of(recordings),
    )
    require_stops(silence, "stale_scan", help, habit)
    for recording in others:
        require_standing(recording, "stale_scan", help, habit)


@pytest.mark.check(points=5, scenarios=("safe_blind", SHOWS), needs=("wiring",))
def test_blind_scan(recordings: Recordings) -> None:
    """When the newest scan has no usable reading ahead the robot stands; +inf is free."""
    for recording in recordings[:1]:
        require_stops(
            recording,
            "stale_scan",
            "The newest scan counts: if it is blind, an older distance is no help.",
            habit_of(recordings),
        )


@pytest.mark.check(points=5, scenarios=("safe_obstacle", LONG, BUSY, SHOWS), needs=("wiring",))
def test_obstacle(recordings: Recordings) -> None:
    """Below 0.5 m ahead no driving forwards; turning (clamped) and backing out as asked."""
    obstacle, long, busy, _ = recordings
    help, habit = (
        "Only if linear.x > 0 and something is nearer than 0.5 m ahead: linear.x = 0, "
        "angular.z as asked, within ±1.9.",
        habit_of(recordings),
    )
    require_commands(
        obstacle,
        help,
        lambda tick: "obstacle" in tick.reasons or is_settled(tick),
        habit=habit,
    )
    for recording in (long, busy):
        require_standing(recording, "obstacle", help, habit)
    require_turning(long, "obstacle", help, habit)


@pytest.mark.check(points=5, scenarios=("safe_drive",), needs=("wiring",))
def test_no_contact(recordings: Recordings) -> None:
    """With a model that never brakes the robot touches nothing, and drives."""
    for recording in recordings:
        require_alive(recording)
        require_no_contact(
            recording, "Watch the replay from a second before: what was ahead, and what was said?"
        )
        driven = path_length(recording)
        if driven < LEAST_WAY:
            fail(
                "the robot hardly moved, so this proves nothing",
                expected=f"at least {LEAST_WAY} m",
                actual=f"{driven:.2f} m",
                at=came_to_rest(recording),
                recording=recording,
                help="Get passes_on and acceleration right first.",
            )


@pytest.mark.check(points=5, scenarios=SHORT, needs=("wiring",))
def test_status_text(recordings: Recordings) -> None:
    """Each message on /diagnostics has one status, whose text begins with a reason word."""
    for recording in recordings:
        require_text(recording)


@pytest.mark.check(points=5, scenarios=SHORT, needs=("wiring", "status_text"))
def test_reasons(recordings: Recordings) -> None:
    """The reason is the right one, and a new one is reported at once."""
    habit = habit_of(recordings)
    for recording in recordings:
        require_reasons(
            recording,
            "Report when the reason differs from that of the last report. The rule that gives the "
            "command also gives the reason.",
            alone=True,
            habit=habit,
        )


@pytest.mark.check(
    points=5,
    scenarios=("safe_first_match", "safe_first_button", LONG, SHOWS),
    needs=("wiring", "status_text"),
)
def test_first_match(recordings: Recordings) -> None:
    """When two rules match, the one that comes first gives the reason, for as long as they do."""
    shows, button, long, _ = recordings
    help, habit = (
        "In this order: e_stop, bad_command, stale_command, stale_scan, obstacle, limited, ok.",
        habit_of(recordings),
    )
    require_first_match(shows, help, habit)
    require_first_match(button, help, habit, least=0)
    if long.outcome.completed and all(map(stands, standing(long, "bad_command", habit))):
        require_first_match(long, help, habit, least=0)


@pytest.mark.check(points=5, scenarios=(*SHORT, "safe_blind"), needs=("wiring", "status_text"))
def test_levels(recordings: Recordings) -> None:
    """Level OK for ok, WARN for limited and obstacle, ERROR for the rest."""
    for recording in judged_to_its_end(recordings):
        require_levels(recording)


@pytest.mark.check(points=5, scenarios=(*EVERY, LONG), needs=("wiring",))
def test_heartbeat(recordings: Recordings) -> None:
    """/diagnostics is never silent for longer than a second, however long a reason holds."""
    for recording in judged_to_its_end(recordings):
        require_heartbeat(recording)
