"""The field checks of exercise 9: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.commands import require_one_command_each
from grader.checks.old_field import FieldSuite
from grader.exercises.latency_monitor.contract import KEYS
from grader.exercises.latency_monitor.evidence import (
    require_numbers,
    require_period,
    require_speeds,
)
from grader.recording import Recording


def _require_contract(recording: Recording, help: str) -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_one_command_each(recording)
    require_speeds(recording, help=help)
    require_period(recording)
    require_numbers(recording, KEYS, "Measure each call of predict, and no other.")


field = FieldSuite("latency_monitor", _require_contract)

test_field_lds01 = field.lds01("latency_field_lds01")
test_field_wide_lidar = field.wide_lidar("latency_field_wide")
test_field_best_effort = field.best_effort("latency_field_best_effort")
test_field_mirrored_world = field.mirrored_world("latency_field_mirrored")
test_field_speckle = field.speckle(
    "latency_field_speckle", title="Takes NaN speckle in its stride."
)
test_field_lost_scans = field.lost_scans("latency_field_lost_scans")
