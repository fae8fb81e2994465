"""The field checks of exercise 1: no points, but the badge *field-ready*."""

from __future__ import annotations

import pytest

from grader.checks.obstacle_avoidance.evidence import (
    answers,
    require_distance,
    require_moving_when_free,
    require_one_command_each,
    require_speed,
)
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording

Recordings = tuple[Recording, ...]
BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."


def _require_contract(recording: Recording, help: str = "") -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_alive(recording)
    require_one_command_each(recording)
    for answer in answers(recording):
        require_speed(recording, answer, help)
    if not recording.scenario.bench_scans:
        require_distance(recording)
        require_moving_when_free(recording)


@pytest.mark.check(
    field=True, scenarios=("avoid_field_lds01_bench", "avoid_field_lds01"), needs=("wiring",)
)
def test_field_lds01(recordings: Recordings) -> None:
    """Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."""
    for recording in recordings:
        _require_contract(recording, BY_ANGLE)


@pytest.mark.check(
    field=True, scenarios=("avoid_field_wide_bench", "avoid_field_wide"), needs=("wiring",)
)
def test_field_wide_lidar(recordings: Recordings) -> None:
    """Works with a lidar of 1080 beams over ±135° at 40 Hz."""
    for recording in recordings:
        _require_contract(recording, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("avoid_field_best_effort",), needs=("wiring",))
def test_field_best_effort(recordings: Recordings) -> None:
    """Hears a lidar driver that publishes best effort (sensor-data QoS)."""
    for recording in recordings:
        require_wiring(recording, "obstacle_avoidance")
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("avoid_field_mirrored",), needs=("wiring",))
def test_field_mirrored_world(recordings: Recordings) -> None:
    """Does the same in a mirrored and rotated world."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("avoid_field_speckle",), needs=("wiring",))
def test_field_speckle(recordings: Recordings) -> None:
    """Takes NaN speckle and noise in its stride."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("avoid_field_lost_scans",), needs=("wiring",))
def test_field_lost_scans(recordings: Recordings) -> None:
    """Drives safely when one scan in five is lost."""
    for recording in recordings:
        _require_contract(recording)
