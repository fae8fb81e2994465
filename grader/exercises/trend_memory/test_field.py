"""The field checks of exercise 4: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import FieldSuite
from grader.checks.verbs import answers_once, follows, keeps_distance
from grader.exercises.trend_memory.contract import TOPIC


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    answers_once(runs)
    for tag in ("pace", "full"):
        follows(runs, tag, topic=TOPIC, help=help)
    follows(runs, "command", help=help)
    keeps_distance(runs)


field = FieldSuite(_keeps_the_contract)

test_field_lds01 = field.lds01("trend_field_lds01")
test_field_wide_lidar = field.wide_lidar("trend_field_wide")
test_field_best_effort = field.best_effort("trend_field_best_effort")
test_field_mirrored_world = field.mirrored_world("trend_field_mirrored")
test_field_speckle = field.speckle("trend_field_speckle")
test_field_lost_scans = field.lost_scans(
    "trend_field_lost_scans", title="Keeps to the stamps when one scan in five is lost."
)
