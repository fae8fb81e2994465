"""The core checks of exercise 7; they sum to 100 points."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checks.driving import path_length, require_no_contact
from grader.checks.moments import came_to_rest
from grader.checks.safety_supervisor.contract import (
    MAX_SPEED,
    MAX_TURN_RATE,
    TOLERANCE,
    is_right_or_never_reverses,
    is_settled,
)
from grader.checks.safety_supervisor.evidence import (
    require_commands,
    require_heartbeat,
    require_levels,
    require_other_fields,
    require_rate,
    require_reasons,
    require_stops,
    require_text,
)
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording

SHORT = (
    "safe_pass",
    "safe_limits",
    "safe_ramp",
    "safe_e_stop",
    "safe_stale_command",
    "safe_stale_scan",
    "safe_obstacle",
)  # every reason but bad_command
LEAST_WAY = 0.5  # [m]

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=("safe_pass",))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to 3 topics and publishes on /cmd_vel and /diagnostics."""
    for recording in recordings:
        require_wiring(recording, "safety_supervisor")


@pytest.mark.check(
    points=5,
    scenarios=("safe_pass", "safe_stale_command", "safe_stale_scan"),
    needs=("wiring",),
)
def test_control_rate(recordings: Recordings) -> None:
    """20 commands a second from the start on, whether or not anything arrives."""
    for recording in recordings:
        require_rate(recording)


@pytest.mark.check(points=5, scenarios=("safe_pass",), needs=("wiring",))
def test_passes_on(recordings: Recordings) -> None:
    """What is safe is passed on as it is, backwards too; the four other fields are zero."""
    for recording in recordings:
        require_commands(
            recording,
            "Where no rule stops or limits it, linear.x and angular.z go out as they came in; "
            "linear.x gets there in steps of 0.045 from what was published last.",
            is_settled,
        )
        require_other_fields(recording)


@pytest.mark.check(points=5, scenarios=("safe_limits",), needs=("wiring",))
def test_limits(recordings: Recordings) -> None:
    """linear.x is clamped to ±0.5 m/s and angular.z to ±1.9 rad/s."""
    for recording in recordings:
        require_alive(recording)
        twists = recording.twists()
        for column, name, limit in ((0, "linear.x", MAX_SPEED), (5, "angular.z", MAX_TURN_RATE)):
            within = np.abs(twists.values[:, column]) <= limit + TOLERANCE  # never true of NaN
            wrong = np.flatnonzero(~within)
            if len(wrong):
                fail(
                    f"{name} is out of its limits",
                    expected=f"|{name}| ≤ {limit}",
                    actual=f"{name} = {twists.values[wrong[0], column]:.2f}",
                    at=float(twists.t[wrong[0]]),
                    recording=recording,
                    help="Clamp both ways: max(-limit, min(limit, value)).",
                )
        require_commands(
            recording,
            "Clamp to the limit, not to zero; what is within is not touched.",
            is_settled,
            right=is_right_or_never_reverses,
        )


@pytest.mark.check(points=10, scenarios=("safe_ramp",), needs=("wiring",))
def test_acceleration(recordings: Recordings) -> None:
    """linear.x rises by at most 0.045 m/s a tick, from the last command published or from 0."""
    for recording in recordings:
        require_commands(
            recording,
            "The most is max(0, last) + 0.045, where last is what you published one tick ago, "
            "whatever the reason for it was.",
            lambda tick: any(decision.rising for decision in tick.right),
            right=lambda tick: tick.is_right,
        )


@pytest.mark.check(points=5, scenarios=("safe_ramp",), needs=("wiring",))
def test_never_delays(recordings: Recordings) -> None:
    """Slowing down, stopping and driving backwards take effect at once."""
    for recording in recordings:
        require_commands(
            recording,
            "The limit is for getting faster forwards only: min(asked, max(0, last) + 0.045).",
            lambda tick: not any(d.rising or d.reason == "e_stop" for d in tick.right),
            right=is_right_or_never_reverses,
        )


@pytest.mark.check(points=10, scenarios=("safe_e_stop",), needs=("wiring",))
def test_e_stop(recordings: Recordings) -> None:
    """While the last /e_stop was true the robot stands, from the next tick on."""
    for recording in recordings:
        require_stops(recording, "e_stop", "Keep the last /e_stop: true holds until a false comes.")


@pytest.mark.check(points=5, scenarios=("safe_bad_command",), needs=("wiring",))
def test_bad_command(recordings: Recordings) -> None:
    """A command with NaN or infinity in a field stops the robot until a good one comes."""
    for recording in recordings:
        require_stops(
            recording,
            "bad_command",
            "math.isfinite on each field, before you compare: comparisons with NaN are false.",
        )


@pytest.mark.check(points=5, scenarios=("safe_stale_command",), needs=("wiring",))
def test_stale_command(recordings: Recordings) -> None:
    """Without a raw command for more than 0.5 s (or at all) the robot stands."""
    for recording in recordings:
        require_stops(
            recording,
            "stale_command",
            "Note when each command arrives, and look at its age at every tick.",
        )


@pytest.mark.check(points=5, scenarios=("safe_stale_scan",), needs=("wiring",))
def test_stale_scan(recordings: Recordings) -> None:
    """Without a scan for more than 0.5 s (or at all) the robot stands."""
    for recording in recordings:
        require_stops(
            recording,
            "stale_scan",
            "Note when each scan arrives, and look at its age at every tick.",
        )


@pytest.mark.check(points=5, scenarios=("safe_blind",), needs=("wiring",))
def test_blind_scan(recordings: Recordings) -> None:
    """When the newest scan has no usable reading ahead the robot stands; +inf is free."""
    for recording in recordings:
        require_stops(
            recording,
            "stale_scan",
            "The newest scan counts: if it is blind, an older distance is no help.",
        )


@pytest.mark.check(points=5, scenarios=("safe_obstacle",), needs=("wiring",))
def test_obstacle(recordings: Recordings) -> None:
    """Below 0.5 m ahead no driving forwards; turning (clamped) and backing out as asked."""
    for recording in recordings:
        require_commands(
            recording,
            "Only if linear.x > 0 and something is nearer than 0.5 m ahead: linear.x = 0, "
            "angular.z as asked, within ±1.9.",
            lambda tick: "obstacle" in tick.reasons or is_settled(tick),
        )


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
    for recording in recordings:
        require_reasons(
            recording,
            "Report when the reason differs from that of the last report. The rule that gives the "
            "command also gives the reason.",
        )


@pytest.mark.check(
    points=5,
    scenarios=("safe_first_match",),
    needs=("reasons", "e_stop", "bad_command", "stale_command", "stale_scan", "obstacle"),
)
def test_first_match(recordings: Recordings) -> None:
    """When two rules match, the one that comes first gives the reason."""
    for recording in recordings:
        require_reasons(
            recording,
            "In this order: e_stop, bad_command, stale_command, stale_scan, obstacle, limited, ok.",
        )


@pytest.mark.check(points=5, scenarios=SHORT, needs=("wiring", "status_text"))
def test_levels(recordings: Recordings) -> None:
    """Level OK for ok, WARN for limited and obstacle, ERROR for the rest."""
    for recording in recordings:
        require_levels(recording)


@pytest.mark.check(points=5, scenarios=("safe_pass", "safe_stale_scan"), needs=("wiring",))
def test_heartbeat(recordings: Recordings) -> None:
    """/diagnostics is never silent for longer than a second."""
    for recording in recordings:
        require_heartbeat(recording)
