"""The field checks of exercise 6: no points, but the badge *field-ready*."""

from __future__ import annotations

from itertools import pairwise

from grader.checks.case import Runs
from grader.checks.check import TIMING, check
from grader.checks.field import FieldSuite
from grader.checks.verdict import fail
from grader.exercises.model_server.clients import (
    ASK_PERIOD,
    NEXT_REQUEST,
    ROLES,
    beats,
)
from grader.exercises.model_server.contract import keeps
from grader.exercises.model_server.notes import NEAR
from grader.exercises.model_server.server import SERVER
from grader.recording import Recording

LONGEST_WAIT = 1.6  # [s] between two detections of one client, with a model that takes 0.3 s
NEEDS = ("client_wiring",)


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
    _in_time(runs[0], 0.0, runs[0].duration_s, LONGEST_WAIT, LONGEST_WAIT)


@check(field=True, asks=TIMING, scenarios=("detect_field_restart",), needs=NEEDS)
def test_field_restart(runs: Runs) -> None:
    """The server is killed and restarted, and everything goes on."""
    beats(runs[0])
    for life in runs[0].scenario.program:
        if life.file == SERVER:
            end = life.stop or runs[0].duration_s
            _in_time(runs[0], life.start, end, NEXT_REQUEST + NEAR, ASK_PERIOD + NEAR)


def _in_time(recording: Recording, begin: float, end: float, first: float, wait: float) -> None:
    """Fail if a client waits over `first` [s] for a detection, or over `wait` [s] for the next."""
    for role in ROLES:
        heard = [t for t in recording.times(f"/{role}/detection").tolist() if begin <= t <= end]
        limits = [first] + [wait] * len(heard)
        for limit, (before, after) in zip(limits, pairwise([begin, *heard, end]), strict=True):
            if after - before > limit:
                fail(
                    f"{role}_client has to wait for a detection for {after - before:.2f} s",
                    expected=f"one within {limit:.2f} s",
                    actual=f"none from {before:.2f} s to {after:.2f} s",
                    at=before,
                    recording=recording,
                    help="Is the server done with a request in time to answer two more within 1 s? "
                    "Do old scans wait in the queue of its subscription (depth)? Does a new server "
                    "find traces of the old?",
                )
