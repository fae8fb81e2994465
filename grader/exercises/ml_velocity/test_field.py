"""The field checks of exercise 2: no points, but the badge *field-ready*."""

from __future__ import annotations

from functools import partial

from grader.checks.field import FieldSuite
from grader.checks.model_commands import keeps_contract
from grader.exercises.ml_velocity.contract import FOREST, TOLERANCE

field = FieldSuite(partial(keeps_contract, tolerance=TOLERANCE))

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
