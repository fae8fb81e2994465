"""The field checks of exercise 11: no points, a badge."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import FieldSuite
from grader.checks.verbs import follows
from grader.exercises.three_nodes.contract import NODES


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    follows(runs, "distance", help=help, topic="/shuttle/distance")
    follows(runs, "speed", help=help)


field = FieldSuite(
    _keeps_the_contract, needs=("connected",), nodes=tuple(node.lstrip("/") for node in NODES)
)

test_field_best_effort = field.best_effort("shuttle_field_best_effort")
test_field_lds01 = field.lds01("shuttle_field_lds01")
