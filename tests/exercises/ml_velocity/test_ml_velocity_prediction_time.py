"""Training checks: whose fault a late prediction is, and a model that says no number."""

import contextlib
import importlib
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.case import Runs
from grader.checks.verdict import CheckFailed, Inconclusive
from grader.recording.training import ModelAnswers, ScriptRun, Training


@pytest.mark.parametrize(
    ("late", "cpu", "verdict"),
    [
        (0, 0.004, None),
        (1, np.nan, None),  # 99 of 100 are enough
        (20, 0.15, CheckFailed),  # it computes
        (20, 0.004, Inconclusive),  # it waited for a CPU
        (20, np.nan, Inconclusive),  # nobody knows
        (190, np.nan, CheckFailed),  # no machine is as busy as that
    ],
)
def test_late_predictions(
    pytestconfig: pytest.Config, late: int, cpu: float, verdict: type[Exception] | None
) -> None:
    """Let so many of 300 predictions take 0.15 s, of which `cpu` was computing [s]."""
    wall = np.where(np.arange(300) < late, 0.15, 0.005)
    spent = np.where(wall > 0.1, cpu, np.minimum(wall, cpu))
    made = Training("train.py", single_wall=wall.tobytes(), single_cpu=spent.tobytes())
    recording: Any = SimpleNamespace(name="ml_training", training=made)
    pytestconfig.addinivalue_line("markers", "check: a check of the grader")
    judge = importlib.import_module("grader.exercises.ml_velocity.test_training")
    with pytest.raises(verdict) if verdict else contextlib.nullcontext():
        judge.test_prediction_time(Runs([recording], lambda _: []))


def test_a_model_that_says_nan_is_not_accurate(pytestconfig: pytest.Config) -> None:
    nan, speeds = (np.full(9, value).tobytes() for value in (np.nan, 0.3))
    made = Training("train.py", pickle=ModelAnswers("", True, (9,), nan), labels=speeds)
    recording: Any = SimpleNamespace(name="ml_training", training=made)
    pytestconfig.addinivalue_line("markers", "check: a check of the grader")
    judge = importlib.import_module("grader.exercises.ml_velocity.test_training")
    with pytest.raises(CheckFailed):
        judge.test_model_accuracy(Runs([recording], lambda _: []))


@pytest.mark.parametrize("problem", ["", "NoneType has no predict"])
def test_a_pickle_before_an_error_counts_if_it_predicts(problem: str) -> None:
    checks = importlib.import_module("grader.exercises.ml_velocity.test_training")
    failed = ScriptRun("exception", "ValueError", "", 1.0, {checks.PICKLE: 900})
    training = Training("train.py", runs=(failed,), pickle=ModelAnswers(problem, loaded=True))
    assert checks._wrote_first(training, failed) == (not problem)
