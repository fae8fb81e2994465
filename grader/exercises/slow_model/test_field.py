"""The field checks of exercise 5: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import FieldSuite
from grader.exercises.slow_model.words import heeds, keeps_period


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless control and inference do their part, at held scans or behind the leader."""
    keeps_period(runs)
    for recording in runs:
        tags = ("known", "idle") if recording.scenario.bench_scans else ("known", "rate", "age")
        heeds(runs.of([recording]), *tags, help=help)


field = FieldSuite(_keeps_the_contract)

test_field_lds01 = field.lds01("slow_field_lds01")
test_field_wide_lidar = field.wide_lidar("slow_field_wide")
test_field_best_effort = field.best_effort("slow_field_best_effort")
test_field_mirrored_world = field.mirrored_world("slow_field_mirrored")
test_field_speckle = field.speckle("slow_field_speckle", title="Takes NaN speckle in its stride.")
test_field_lost_scans = field.lost_scans("slow_field_lost_scans")
