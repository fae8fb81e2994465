"""The field checks of exercise 5: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import FieldSuite
from grader.checks.predictions import TOLERANCE
from grader.checks.words import follows
from grader.exercises.slow_model.contract import IDLE, KNOWN, TICK
from grader.exercises.slow_model.words import (
    AGE_P95,
    LEAST_RATE,
    heeds,
    keeps_going,
    keeps_period,
    stays_young,
)

LATER = 0.1  # [s] a worker that waits for a new scan waits for one more when that one is lost


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds, at held scans or behind the leader."""
    keeps_period(runs)
    for recording in runs:
        run = runs.of([recording])
        if recording.scenario.bench_scans:
            follows(run, TICK, KNOWN, IDLE, help=help, tolerance=TOLERANCE)
        else:
            heeds(run, KNOWN, help=help)
            keeps_going(run, LEAST_RATE)
            stays_young(run, AGE_P95 + LATER * (recording.scenario.faults.scan_loss > 0))


field = FieldSuite(_keeps_the_contract)

test_field_lds01 = field.lds01("slow_field_lds01")
test_field_wide_lidar = field.wide_lidar("slow_field_wide")
test_field_best_effort = field.best_effort("slow_field_best_effort")
test_field_mirrored_world = field.mirrored_world("slow_field_mirrored")
test_field_speckle = field.speckle("slow_field_speckle", title="Takes NaN speckle in its stride.")
test_field_lost_scans = field.lost_scans("slow_field_lost_scans")
