"""The field checks of exercise 2: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.commands import require_one_command_each
from grader.checks.model_commands import require_safe_drive
from grader.checks.old_field import FieldSuite
from grader.exercises.ml_velocity.contract import FOREST, LEAST_WAY
from grader.exercises.ml_velocity.evidence import require_speeds
from grader.recording import Recording


def _require_contract(recording: Recording, help: str) -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_one_command_each(recording)
    if recording.scenario.bench_scans:
        require_speeds(recording, help=help)
    else:
        require_safe_drive(recording, "the grader's", LEAST_WAY)


field = FieldSuite("ml_velocity", _require_contract)

test_field_lds01 = field.lds01("ml_field_lds01_front", "ml_field_lds01_left")
test_field_wide_lidar = field.wide_lidar("ml_field_wide_front", "ml_field_wide_left")
test_field_best_effort = field.best_effort("ml_field_best_effort")
test_field_speckle = field.speckle(
    "ml_field_speckle",
    title="Takes NaN speckle and noise in its stride, in a mirrored and rotated world.",
    requires=FOREST,
)
test_field_lost_scans = field.lost_scans(
    "ml_field_lost_scans", title="Answers the scans that come when one in five is lost."
)
