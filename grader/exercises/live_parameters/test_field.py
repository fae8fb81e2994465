"""The field checks of exercise 10: no points, a badge."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import FieldSuite
from grader.checks.verbs import answers_once, follows


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    answers_once(runs)
    follows(runs, "scan", help=help)


field = FieldSuite(_keeps_the_contract)

test_field_best_effort = field.best_effort("live_field_best_effort")
test_field_lds01 = field.lds01("live_field_lds01")
