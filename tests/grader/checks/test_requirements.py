"""A check says which libraries its scenarios need, so that it can be left out without them."""

import importlib

import pytest

from grader.course.exercises import Exercise, all_exercises
from grader.models.files import LEARNED, OWN
from sim.scenario_files import load_scenario


def required(scenario: str) -> set[str]:
    """Return what the judge needs to make the models of a scenario."""
    loaded = load_scenario(scenario)
    models = loaded.node.models.items()
    if loaded.training is not None or any(model.probe == OWN for _, model in models):
        return {"sklearn", "skl2onnx", "onnxruntime"}
    learned = (*LEARNED, "trained")
    pickled = [m for name, m in models if name.lower().endswith(".pkl") and m.probe in learned]
    return {"sklearn"} if pickled else set()


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_checks_require_what_their_scenarios_need(
    exercise: Exercise, pytestconfig: pytest.Config
) -> None:
    pytestconfig.addinivalue_line("markers", "check: of the judge's own pytest")
    found = 0
    for path in sorted(exercise.judge.glob("test_*.py")):
        module = importlib.import_module(f"grader.exercises.{exercise.slug}.{path.stem}")
        for name, check in vars(module).items():
            for mark in getattr(check, "pytestmark", []):
                if not name.startswith("test_") or mark.name != "check":
                    continue
                found += 1
                needed = set().union(*(required(s) for s in mark.kwargs.get("scenarios", ())))
                assert needed <= set(mark.kwargs.get("requires", ())), name
    assert found, "no checks in its test_*.py"
