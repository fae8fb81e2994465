"""The field checks of exercise 5: no points, but the badge *field-ready*."""

from __future__ import annotations

import pytest

from grader.checks.slow_model.contract import AGE_P95, LEAST_RATE
from grader.checks.slow_model.evidence import require_ages, require_held, require_rate
from grader.checks.slow_model.test_core import require_period
from grader.checks.wiring import require_wiring
from grader.recording import Recording

Recordings = tuple[Recording, ...]
BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."


def _require_drive(recording: Recording, least: float = LEAST_RATE) -> None:
    """Fail unless the whole contract holds behind the leader."""
    require_period(recording)
    require_rate(recording, least)
    require_ages(recording, AGE_P95)


@pytest.mark.check(field=True, scenarios=("slow_field_lds01",), needs=("wiring",))
def test_field_lds01(recordings: Recordings) -> None:
    """Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."""
    for recording in recordings:
        require_period(recording)
        require_held(recording, "field", BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("slow_field_wide",), needs=("wiring",))
def test_field_wide_lidar(recordings: Recordings) -> None:
    """Works with a lidar of 1080 beams over ±135° at 40 Hz."""
    for recording in recordings:
        require_period(recording)
        require_held(recording, "field", BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("slow_field_best_effort",), needs=("wiring",))
def test_field_best_effort(recordings: Recordings) -> None:
    """Hears a lidar driver that publishes best effort (sensor-data QoS)."""
    for recording in recordings:
        require_wiring(recording, "slow_model")
        _require_drive(recording)


@pytest.mark.check(field=True, scenarios=("slow_field_mirrored",), needs=("wiring",))
def test_field_mirrored_world(recordings: Recordings) -> None:
    """Does the same in a mirrored and rotated world."""
    for recording in recordings:
        _require_drive(recording)


@pytest.mark.check(field=True, scenarios=("slow_field_speckle",), needs=("wiring",))
def test_field_speckle(recordings: Recordings) -> None:
    """Takes NaN speckle in its stride."""
    for recording in recordings:
        _require_drive(recording)


@pytest.mark.check(field=True, scenarios=("slow_field_lost_scans",), needs=("wiring",))
def test_field_lost_scans(recordings: Recordings) -> None:
    """Goes on when one scan in five is lost."""
    for recording in recordings:
        _require_drive(recording)
