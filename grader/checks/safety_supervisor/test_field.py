"""The field checks of exercise 7: no points, but the badge *field-ready*."""

from __future__ import annotations

import pytest

from grader.checks.moments import first_contact
from grader.checks.safety_supervisor.evidence import (
    require_commands,
    require_heartbeat,
    require_levels,
    require_rate,
    require_reasons,
    require_text,
)
from grader.checks.verdict import fail
from grader.checks.wiring import require_wiring
from grader.recording import Recording

Recordings = tuple[Recording, ...]
BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."


def _require_contract(recordings: Recordings, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    for recording in recordings:
        require_wiring(recording, "safety_supervisor")
        require_rate(recording)
        require_commands(recording, help)
        require_text(recording)
        require_reasons(recording, help)
        require_levels(recording)
        require_heartbeat(recording)
        if recording.truth.contact.any():
            fail(
                "the robot ran into something",
                expected="no contact",
                actual="contact",
                at=first_contact(recording),
                recording=recording,
                help=help,
            )


@pytest.mark.check(field=True, scenarios=("safe_field_lds01",), needs=("wiring",))
def test_field_lds01(recordings: Recordings) -> None:
    """Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."""
    _require_contract(recordings, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("safe_field_wide",), needs=("wiring",))
def test_field_wide_lidar(recordings: Recordings) -> None:
    """Works with a lidar of 1080 beams over ±135° at 40 Hz."""
    _require_contract(recordings, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("safe_field_best_effort",), needs=("wiring",))
def test_field_best_effort(recordings: Recordings) -> None:
    """Hears a lidar driver that publishes best effort (sensor-data QoS)."""
    _require_contract(recordings, "Subscribe to /scan with qos_profile_sensor_data.")


@pytest.mark.check(field=True, scenarios=("safe_field_mirrored",), needs=("wiring",))
def test_field_mirrored_world(recordings: Recordings) -> None:
    """Does the same in a mirrored and rotated world."""
    _require_contract(recordings, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("safe_field_speckle",), needs=("wiring",))
def test_field_speckle(recordings: Recordings) -> None:
    """Takes NaN speckle and noise in its stride."""
    _require_contract(recordings, "A NaN says nothing; the other readings of the scan still do.")


@pytest.mark.check(field=True, scenarios=("safe_field_lost_scans",), needs=("wiring",))
def test_field_lost_scans(recordings: Recordings) -> None:
    """Counts ages from the arrival: scans come late, and one in five never does."""
    _require_contract(recordings, "The age of a scan counts from its arrival, not from its stamp.")
