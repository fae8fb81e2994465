"""The field checks of exercise 4: no points, but the badge *field-ready*."""

from __future__ import annotations

import pytest

from grader.checks.obstacle_avoidance.evidence import require_one_command_each
from grader.checks.trend_memory.evidence import (
    cases,
    require_closing_speeds,
    require_distance,
    require_speed,
    require_way,
)
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording

Recordings = tuple[Recording, ...]
BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."


def _require_contract(recordings: Recordings, help: str = "") -> None:
    """Fail unless the whole contract holds in these scenarios."""
    for recording in recordings:
        require_alive(recording)
        require_one_command_each(recording)
        require_closing_speeds(recording, help)
        for case in cases(recording):
            require_speed(recording, case, help)
        require_distance(recording)
    require_way(recordings)


@pytest.mark.check(field=True, scenarios=("trend_field_lds01",), needs=("wiring",))
def test_field_lds01(recordings: Recordings) -> None:
    """Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."""
    _require_contract(recordings, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("trend_field_wide",), needs=("wiring",))
def test_field_wide_lidar(recordings: Recordings) -> None:
    """Works with a lidar of 1080 beams over ±135° at 40 Hz."""
    _require_contract(recordings, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("trend_field_best_effort",), needs=("wiring",))
def test_field_best_effort(recordings: Recordings) -> None:
    """Hears a lidar driver that publishes best effort (sensor-data QoS)."""
    for recording in recordings:
        require_wiring(recording, "trend_memory")
    _require_contract(recordings)


@pytest.mark.check(field=True, scenarios=("trend_field_mirrored",), needs=("wiring",))
def test_field_mirrored_world(recordings: Recordings) -> None:
    """Does the same in a mirrored and rotated world."""
    _require_contract(recordings)


@pytest.mark.check(field=True, scenarios=("trend_field_speckle",), needs=("wiring",))
def test_field_speckle(recordings: Recordings) -> None:
    """Takes NaN speckle and noise in its stride."""
    _require_contract(recordings)


@pytest.mark.check(field=True, scenarios=("trend_field_lost_scans",), needs=("wiring",))
def test_field_lost_scans(recordings: Recordings) -> None:
    """Keeps to the stamps when one scan in five is lost."""
    _require_contract(recordings)
