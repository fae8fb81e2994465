"""The field checks of exercise 4: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.commands import require_one_command_each
from grader.checks.old_field import FieldSuite
from grader.exercises.trend_memory.evidence import (
    cases,
    require_closing_speeds,
    require_distance,
    require_speed,
    require_way,
)
from grader.exercises.trend_memory.habits import Habits
from grader.recording import Recording


def _require_contract(recording: Recording, help: str) -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_one_command_each(recording)
    require_closing_speeds(recording, help)
    for case in cases(recording):
        require_speed(recording, case, help)
    require_distance(recording)
    require_way(recording, Habits())


field = FieldSuite("trend_memory", _require_contract)

test_field_lds01 = field.lds01("trend_field_lds01")
test_field_wide_lidar = field.wide_lidar("trend_field_wide")
test_field_best_effort = field.best_effort("trend_field_best_effort")
test_field_mirrored_world = field.mirrored_world("trend_field_mirrored")
test_field_speckle = field.speckle("trend_field_speckle")
test_field_lost_scans = field.lost_scans(
    "trend_field_lost_scans", title="Keeps to the stamps when one scan in five is lost."
)
