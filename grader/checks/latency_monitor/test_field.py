"""The field checks of exercise 9: no points, but the badge *field-ready*."""

from __future__ import annotations

import pytest

from grader.checks.latency_monitor.contract import KEYS
from grader.checks.latency_monitor.evidence import (
    require_numbers,
    require_one_command_each,
    require_period,
    require_speeds,
)
from grader.checks.wiring import require_wiring
from grader.recording import Recording

Recordings = tuple[Recording, ...]
BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."


def _require_contract(recording: Recording, help: str = "") -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_one_command_each(recording)
    require_speeds(recording, help=help)
    require_period(recording)
    require_numbers(recording, KEYS, "Measure each call of predict, and no other.")


@pytest.mark.check(field=True, scenarios=("latency_field_lds01",), needs=("wiring",))
def test_field_lds01(recordings: Recordings) -> None:
    """Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."""
    for recording in recordings:
        _require_contract(recording, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("latency_field_wide",), needs=("wiring",))
def test_field_wide_lidar(recordings: Recordings) -> None:
    """Works with a lidar of 1080 beams over ±135° at 40 Hz."""
    for recording in recordings:
        _require_contract(recording, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("latency_field_best_effort",), needs=("wiring",))
def test_field_best_effort(recordings: Recordings) -> None:
    """Hears a lidar driver that publishes best effort (sensor-data QoS)."""
    for recording in recordings:
        require_wiring(recording, "latency_monitor")
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("latency_field_mirrored",), needs=("wiring",))
def test_field_mirrored_world(recordings: Recordings) -> None:
    """Does the same in a mirrored and rotated world."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("latency_field_speckle",), needs=("wiring",))
def test_field_speckle(recordings: Recordings) -> None:
    """Takes NaN speckle in its stride."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("latency_field_lost_scans",), needs=("wiring",))
def test_field_lost_scans(recordings: Recordings) -> None:
    """Goes on when one scan in five is lost."""
    for recording in recordings:
        _require_contract(recording)
