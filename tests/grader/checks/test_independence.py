"""What the checks of several exercises share lies where each grading's fingerprint covers it."""

import tomllib

import pytest

from grader.classroom.conditions import _sources
from grader.course.exercises import CHECKS, ROOT, Exercise, all_exercises


def test_every_exercise_stands_in_the_import_contract() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (contract,) = (each for each in contracts if each["type"] == "independence")
    exercises = {f"grader.checks.{exercise.slug}" for exercise in all_exercises()}
    assert set(contract["modules"]) == exercises


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_a_fingerprint_covers_the_shared_checks_and_the_exercises_own(exercise: Exercise) -> None:
    covered = {path for path in _sources(exercise) if path.is_relative_to(CHECKS)}
    assert covered == {*CHECKS.glob("*.py"), *exercise.checks.glob("*.py")}
