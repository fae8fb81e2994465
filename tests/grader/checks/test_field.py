"""The field suite makes checks like any other, of every exercise's whole contract."""

import importlib
from typing import Any

import pytest

from grader.checks.field import FieldSuite
from grader.course.exercises import all_exercises
from sim.scenario_files import load_scenario

EXERCISES = [exercise.slug for exercise in all_exercises()]


def mark(check: Any) -> dict[str, Any]:
    (found,) = check.pytestmark
    return dict(found.kwargs)


def test_a_check_says_what_it_is() -> None:
    field = FieldSuite(lambda runs, help: None, needs=("server_wiring",))
    check = field.lds01("one", "two", requires=("onnx",))

    assert check.__doc__ == (
        "Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."
    )
    assert mark(check) == {
        "field": True,
        "asks": "decision",
        "points": 0,
        "task": 0,
        "hint": "",
        "scenarios": ("one", "two"),
        "needs": ("server_wiring",),
        "requires": ("onnx",),
    }
    odometry = field.best_effort("three", sensor="an odometry")
    assert (odometry.__doc__ or "").startswith("Hears an odometry driver")
    assert mark(check)["scenarios"] == ("one", "two")


@pytest.mark.parametrize("slug", EXERCISES)
def test_every_exercise_hears_best_effort_and_stands_two_more_surprises(slug: str) -> None:
    module = importlib.import_module(f"grader.exercises.{slug}.test_field")
    checks = {name: check for name, check in vars(module).items() if name.startswith("test_")}

    assert "test_field_best_effort" in checks
    assert len(checks) >= 3
    assert all(name.startswith("test_field_") for name in checks)
    for check in checks.values():
        assert mark(check)["field"] is True
        assert not mark(check).get("points")
        for name in mark(check)["scenarios"]:
            assert load_scenario(name).name == name
