"""The field checks of exercise 8: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.field import FieldSuite
from grader.checks.model_commands import keeps_contract
from grader.exercises.model_formats.contract import ONNX, SKLEARN

field = FieldSuite(keeps_contract)

test_field_lds01 = field.lds01("format_field_lds01", requires=ONNX)
test_field_wide_lidar = field.wide_lidar("format_field_wide", requires=ONNX)
test_field_best_effort = field.best_effort("format_field_best_effort")
test_field_speckle = field.speckle(
    "format_field_speckle",
    title="Takes NaN speckle and noise in its stride, in a mirrored and rotated world.",
    requires=SKLEARN + ONNX,
)
test_field_lost_scans = field.lost_scans(
    "format_field_lost_scans",
    title="Answers the scans that come when one in five is lost.",
    requires=ONNX,
)
