"""The field checks of exercise 6: no points, but the badge *field-ready*."""

from __future__ import annotations

from itertools import product

from grader.checks.case import Runs
from grader.checks.check import TIMING, check
from grader.checks.field import FieldSuite
from grader.checks.verbs import every
from grader.exercises.model_server.clients import ASK_PERIOD, PATIENCE, ROLES, beats
from grader.exercises.model_server.contract import keeps
from grader.exercises.model_server.notes import NEAR
from grader.exercises.model_server.server import SERVER

LONGEST_WAIT = 1.6  # [s] between two detections of one client, with a model that takes 0.3 s
NEEDS = ("client_wiring",)
IN_TIME = (
    "Is the server done with a request in time to answer two more within 1 s? Do old scans wait in "
    "the queue of its subscription (depth)? Does a new server find traces of the old?"
)


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless every answer is right."""
    keeps(runs, "success", "detection", "features", help=help)


server = FieldSuite(_keeps_the_contract, needs=("server_wiring",), nodes=("detection_server",))

test_field_lds01 = server.lds01("detect_field_lds01")
test_field_wide_lidar = server.wide_lidar("detect_field_wide")
test_field_best_effort = server.best_effort("detect_field_best_effort")
test_field_speckle = server.speckle(
    "detect_field_speckle", title="Takes NaN speckle, noise and lost scans in its stride."
)


@check(field=True, asks=TIMING, scenarios=("detect_field_slow_model",), needs=NEEDS)
def test_field_slow_model(runs: Runs) -> None:
    """With a model that takes 0.3 s, each of the three clients gets its answers in time."""
    beats(runs[0])
    for role in ROLES:
        every(runs[0], f"/{role}/detection", LONGEST_WAIT, 0.0, sooner=True, help=IN_TIME)


@check(field=True, asks=TIMING, scenarios=("detect_field_restart",), needs=NEEDS)
def test_field_restart(runs: Runs) -> None:
    """The server is killed and restarted, and everything goes on."""
    beats(runs[0])
    lives = [life for life in runs[0].scenario.program if life.file == SERVER]
    for life, role in product(lives, ROLES):
        every(
            runs[0], f"/{role}/detection", ASK_PERIOD, NEAR,
            begin=life.start + PATIENCE, end=life.stop, sooner=True, help=IN_TIME,
        )  # fmt: skip
