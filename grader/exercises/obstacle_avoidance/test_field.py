"""The field checks of exercise 1: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.commands import answers, require_one_command_each
from grader.checks.field import FieldSuite
from grader.exercises.obstacle_avoidance.evidence import (
    require_distance,
    require_moving_when_free,
    require_speed,
)
from grader.recording import Recording


def _require_contract(recording: Recording, help: str) -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_one_command_each(recording)
    for answer in answers(recording):
        require_speed(recording, answer, help)
    if not recording.scenario.bench_scans:
        require_distance(recording)
        require_moving_when_free(recording)


field = FieldSuite("obstacle_avoidance", _require_contract)

test_field_lds01 = field.lds01("avoid_field_lds01_bench", "avoid_field_lds01")
test_field_wide_lidar = field.wide_lidar("avoid_field_wide_bench", "avoid_field_wide")
test_field_best_effort = field.best_effort("avoid_field_best_effort")
test_field_mirrored_world = field.mirrored_world("avoid_field_mirrored")
test_field_speckle = field.speckle("avoid_field_speckle")
test_field_lost_scans = field.lost_scans(
    "avoid_field_lost_scans", title="Drives safely when one scan in five is lost."
)
