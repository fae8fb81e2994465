"""The field checks of exercise 5: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.old_field import FieldSuite
from grader.exercises.slow_model.contract import AGE_P95, LEAST_RATE
from grader.exercises.slow_model.evidence import (
    require_ages,
    require_held,
    require_period,
    require_rate,
)
from grader.recording import Recording

LATER = 0.1  # [s] a worker that waits for a new scan waits for one more when that one is lost


def _require_contract(recording: Recording, help: str) -> None:
    """Fail unless the whole contract holds, at held scans or behind the leader."""
    require_period(recording)
    if recording.scenario.bench_scans:
        require_held(recording, "field", help)
    else:
        require_rate(recording, LEAST_RATE)
        lossy = recording.scenario.faults.scan_loss > 0
        require_ages(recording, AGE_P95 + LATER * lossy)


field = FieldSuite("slow_model", _require_contract)

test_field_lds01 = field.lds01("slow_field_lds01")
test_field_wide_lidar = field.wide_lidar("slow_field_wide")
test_field_best_effort = field.best_effort("slow_field_best_effort")
test_field_mirrored_world = field.mirrored_world("slow_field_mirrored")
test_field_speckle = field.speckle("slow_field_speckle", title="Takes NaN speckle in its stride.")
test_field_lost_scans = field.lost_scans("slow_field_lost_scans")
