"""The field checks of exercise 8: no points, but the badge *field-ready*."""

from __future__ import annotations

import pytest

from grader.checks.ml_velocity.evidence import require_safe_drive
from grader.checks.model_formats.evidence import require_speeds
from grader.checks.obstacle_avoidance.evidence import require_one_command_each
from grader.checks.wiring import require_wiring
from grader.recording import Recording

ONNX = ("onnx", "onnxruntime")
BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."

Recordings = tuple[Recording, ...]


def _require_contract(recording: Recording, help: str = "") -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_wiring(recording, "model_formats")
    require_one_command_each(recording)
    if recording.scenario.bench_scans:
        require_speeds(recording, help=help)
    else:
        require_safe_drive(recording, "the ONNX")


@pytest.mark.check(field=True, scenarios=("format_field_lds01",), needs=("wiring",), requires=ONNX)
def test_field_lds01(recordings: Recordings) -> None:
    """Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."""
    for recording in recordings:
        _require_contract(recording, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("format_field_wide",), needs=("wiring",), requires=ONNX)
def test_field_wide_lidar(recordings: Recordings) -> None:
    """Works with a lidar of 1080 beams over ±135° at 40 Hz."""
    for recording in recordings:
        _require_contract(recording, BY_ANGLE)


@pytest.mark.check(field=True, scenarios=("format_field_best_effort",), needs=("wiring",))
def test_field_best_effort(recordings: Recordings) -> None:
    """Hears a lidar driver that publishes best effort (sensor-data QoS)."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(
    field=True, scenarios=("format_field_speckle",), needs=("wiring",), requires=("sklearn", *ONNX)
)
def test_field_speckle(recordings: Recordings) -> None:
    """Takes NaN speckle and noise in its stride, in a mirrored and rotated world."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(
    field=True, scenarios=("format_field_lost_scans",), needs=("wiring",), requires=ONNX
)
def test_field_lost_scans(recordings: Recordings) -> None:
    """Answers the scans that come when one in five is lost."""
    for recording in recordings:
        _require_contract(recording)
