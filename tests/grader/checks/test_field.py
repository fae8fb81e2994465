"""The field checks of every exercise: best effort at least, and no points."""

import importlib
from typing import Any

import pytest

from grader.course.exercises import all_exercises
from sim.scenario_files import load_scenario

EXERCISES = [exercise.slug for exercise in all_exercises()]


def mark(check: Any) -> dict[str, Any]:
    (found,) = check.pytestmark
    return dict(found.kwargs)


@pytest.mark.parametrize("slug", EXERCISES)
def test_every_exercise_hears_best_effort(slug: str) -> None:
    module = importlib.import_module(f"grader.exercises.{slug}.test_field")
    checks = {name: check for name, check in vars(module).items() if name.startswith("test_")}

    assert "test_field_best_effort" in checks, f"{module.__file__}: add field.best_effort(…)"
    assert all(name.startswith("test_field_") for name in checks)
    for check in checks.values():
        assert mark(check)["field"] is True
        assert not mark(check).get("points")
        assert check.__doc__
        for name in mark(check)["scenarios"]:
            assert load_scenario(name).name == name
