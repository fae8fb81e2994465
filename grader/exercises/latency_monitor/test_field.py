"""The field checks of exercise 9: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import FieldSuite
from grader.checks.model_commands import predicts
from grader.checks.verbs import answers_once, every
from grader.exercises.latency_monitor.calls import asks_once_each
from grader.exercises.latency_monitor.contract import KEYS
from grader.exercises.latency_monitor.reports import PERIOD, PERIOD_TOLERANCE, TOPIC, reports


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    answers_once(runs)
    predicts(runs, help=help)
    for recording in runs:
        every(recording, TOPIC, PERIOD, PERIOD_TOLERANCE)
    asks_once_each(runs)
    reports(runs, "level", *KEYS, help="Measure each call of predict, and no other.")


field = FieldSuite(_keeps_the_contract)

test_field_lds01 = field.lds01("latency_field_lds01")
test_field_wide_lidar = field.wide_lidar("latency_field_wide")
test_field_best_effort = field.best_effort("latency_field_best_effort")
test_field_mirrored_world = field.mirrored_world("latency_field_mirrored")
test_field_speckle = field.speckle(
    "latency_field_speckle", title="Takes NaN speckle in its stride."
)
test_field_lost_scans = field.lost_scans("latency_field_lost_scans")
