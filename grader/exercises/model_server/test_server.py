"""The core checks of exercise 6's server, 60 points: how it answers the grader's own client."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, WIRING, check
from grader.checks.verbs import logs, wired
from grader.exercises.model_server.contract import keeps

PLAIN, EARLY, LATE = "detect_answers", "detect_no_scan", "detect_late_scans"
BLIND, FAILS, NO_MODEL = "detect_blind", "detect_failing_model", "detect_no_model"
ANSWERS = (PLAIN, "detect_hundred", "detect_numbers")
FEATURES = ("detect_features", EARLY, "detect_readings", "detect_limits")
TOGETHER = "detect_together"
LOADS = (TOGETHER, FAILS, BLIND, LATE, "detect_hundred")
NEEDS = ("server_wiring",)
BOTH = ("server_wiring", "client_wiring")


@check(points=5, asks=WIRING, task=1, scenarios=(PLAIN,), needs=())
def test_server_wiring(runs: Runs) -> None:
    """The server starts, spins, listens to /scan and offers the service /detect."""
    wired(runs, "detection_server")


@check(points=10, asks=DECISION, task=3, scenarios=ANSWERS, needs=NEEDS, hint="3.1")
def test_answers(runs: Runs) -> None:
    """It answers with label, confidence and stamp of the newest scan, as JSON."""
    help = (
        "success = True, and json.dumps of the newest scan's label (what predict returns), "
        "confidence (the greatest of predict_proba) and stamp. Without parameters model_path is "
        "detection_model.pkl."
    )
    keeps(runs, "success", "detection", help=help)


@check(points=10, asks=DECISION, task=3, scenarios=FEATURES, needs=NEEDS, hint="3.1")
def test_features(runs: Runs) -> None:
    """The model is asked about the five features of exercise 2."""
    help = "They are the features of exercise 2, of the newest scan; compare sector by sector."
    keeps(runs, "features", help=help)


@check(points=5, asks=DECISION, task=4, scenarios=(EARLY,), needs=NEEDS, hint="4.1")
def test_no_scan(runs: Runs) -> None:
    """Before the first scan it refuses, and says why."""
    help = "Keep the scan in an attribute that is None at first; without one, message says so."
    keeps(runs, "success", "reason", help=help)


@check(points=5, asks=SAFETY, task=4, scenarios=(LATE,), needs=NEEDS, hint="3.3")
def test_old_scan(runs: Runs) -> None:
    """It refuses when the newest scan is older than 1 s, by the stamp in its header."""
    help = "Compare the node's clock with header.stamp: a scan may have been long on its way."
    keeps(runs, "success", help=help)


@check(points=5, asks=SAFETY, task=4, scenarios=(BLIND,), needs=NEEDS, hint="4.1")
def test_blind_sector(runs: Runs) -> None:
    """It refuses when a sector of the newest scan has no usable reading, and lives on."""
    help = "Only the newest scan counts, even if an older one shows more."
    keeps(runs, "success", help=help)


@check(points=5, asks=DECISION, task=4, scenarios=(NO_MODEL,), needs=NEEDS, hint="2.2")
def test_no_model(runs: Runs) -> None:
    """Without a model file, or with a broken one, it logs an error, starts and refuses."""
    keeps(runs, "success", help="Catch whatever pickle.load raises.")
    *broken, _ = (life for life in runs[0].scenario.program if not life.supplied)
    for life in broken:
        what = "this server has no model"
        logs(runs[0], ("error", "fatal"), what=what, begin=life.start, end=life.stop)


@check(points=5, asks=SAFETY, task=4, scenarios=(FAILS,), needs=NEEDS, hint="4.2")
def test_failing_model(runs: Runs) -> None:
    """It refuses when the model raises or its confidence is not finite, and lives on."""
    help = (
        "Put predict and predict_proba into try … except Exception, and test the confidence with "
        "math.isfinite."
    )
    keeps(runs, "success", help=help)


@check(points=10, asks=STATE, scenarios=LOADS, needs=BOTH, hint="2.1")
def test_one_load(runs: Runs) -> None:
    """Three clients and one more ask, and the model is loaded once in the whole system."""
    help = (
        "pickle.load belongs in the constructor of the server and nowhere else: one process has "
        "the model for all, and a model that failed once is still the same one."
    )
    keeps(runs, "loads", help=help)
    keeps(runs.only(TOGETHER), "success", help="One service has to do for any number of clients.")
