"""The field checks of exercise 1: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import FieldSuite
from grader.checks.verbs import answers_once, drives_on, follows, keeps_distance
from grader.exercises.obstacle_avoidance.contract import FREE


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    answers_once(runs)
    follows(runs, help=help)
    keeps_distance(runs.driven())
    drives_on(runs.driven(), FREE)


field = FieldSuite(_keeps_the_contract)

test_field_lds01 = field.lds01("avoid_field_lds01_bench", "avoid_field_lds01", hint="3.2")
test_field_wide_lidar = field.wide_lidar("avoid_field_wide_bench", "avoid_field_wide", hint="3.1")
test_field_best_effort = field.best_effort("avoid_field_best_effort", hint="1.3")
test_field_mirrored_world = field.mirrored_world("avoid_field_mirrored")
test_field_speckle = field.speckle("avoid_field_speckle")
test_field_lost_scans = field.lost_scans(
    "avoid_field_lost_scans", title="Drives safely when one scan in five is lost."
)
