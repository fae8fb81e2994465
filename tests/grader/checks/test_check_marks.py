"""The marks of every exercise's checks: the field suite, and the libraries that they require."""

import importlib
from typing import Any

import pytest

from grader.course.exercises import Exercise, all_exercises
from grader.models.files import LEARNED, OWN
from sim.scenario_files import load_scenario

each_exercise = pytest.mark.parametrize("exercise", all_exercises(), ids=lambda each: each.slug)


def marks(exercise: Exercise, file: str) -> dict[str, dict[str, Any]]:
    """Return the marks of the checks in an exercise's file, by the test's name."""
    module = importlib.import_module(f"grader.exercises.{exercise.slug}.{file}")
    checks = {name: check for name, check in vars(module).items() if name.startswith("test_")}
    assert all(check.__doc__ for check in checks.values())
    return {name: dict(check.pytestmark[0].kwargs) for name, check in checks.items()}


def required(scenario: str) -> set[str]:
    """Return what the judge needs to make the models of a scenario."""
    loaded = load_scenario(scenario)
    models = loaded.node.models.items()
    if loaded.training is not None or any(model.probe == OWN for _, model in models):
        return {"sklearn", "skl2onnx", "onnxruntime"}
    learned = (*LEARNED, "trained")
    pickled = [m for name, m in models if name.lower().endswith(".pkl") and m.probe in learned]
    return {"sklearn"} if pickled else set()


@each_exercise
def test_field_checks_have_no_points_and_one_hears_best_effort(exercise: Exercise) -> None:
    found = marks(exercise, "test_field")
    assert "test_field_best_effort" in found, f"{exercise.slug}: add field.best_effort(…)"
    assert all(name.startswith("test_field_") for name in found)
    assert all(mark["field"] and not mark["points"] for mark in found.values())


@each_exercise
def test_checks_require_what_their_scenarios_need(exercise: Exercise) -> None:
    found = [
        m for file in exercise.judge.glob("test_*.py") for m in marks(exercise, file.stem).items()
    ]
    assert found, "no checks in its test_*.py"
    for name, mark in found:
        needed = set().union(*(required(scenario) for scenario in mark["scenarios"]))
        assert needed <= set(mark["requires"]), name
