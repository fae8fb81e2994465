"""Commands near what the model says: one check names it, the others judge what else is wrong."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks import model_commands
from grader.checks.inferences import require_kept
from grader.checks.verdict import CheckFailed
from grader.exercises.model_formats import habits
from grader.exercises.model_formats.evidence import Habits
from grader.recording import Inference


@pytest.mark.parametrize(
    ("off", "near", "tolerance"), [(0.0, False, 1e-3), (0.005, True, 6e-3), (0.02, False, 1e-3)]
)
def test_a_node_that_rounds_is_near(
    monkeypatch: pytest.MonkeyPatch, off: float, near: bool, tolerance: float
) -> None:
    def require_speeds(_: Any, habits: Habits) -> None:
        if off > habits.tolerance:
            raise CheckFailed("wrong speed")

    monkeypatch.setattr(habits, "require_speeds", require_speeds)
    readings: Any = "readings"
    found = habits.habits_of(readings)
    assert found == Habits(tolerance)
    assert ("is a number rounded?" in habits.slip(found)) is near


@pytest.mark.parametrize(
    ("speed", "problem"), [(0.28, "near what the model said"), (0.2, "does not come from")]
)
def test_rounded_is_not_made_up(
    monkeypatch: pytest.MonkeyPatch, speed: float, problem: str
) -> None:
    asked = [Inference("predict", "m", 1, 1, 0, (0.2833,))]
    monkeypatch.setattr(model_commands, "questions", lambda *_: asked)
    monkeypatch.setattr(model_commands, "possible_features", lambda _: [1.0])
    monkeypatch.setattr(model_commands, "max_speed", lambda _: 0.5)
    recording: Any = SimpleNamespace(name="format_readings", scenario=None)
    scan: Any = SimpleNamespace(t=1.0)
    with pytest.raises(CheckFailed, match=problem):
        model_commands.require_asked(recording, scan, 2.0, speed, 1e-3, what="the scan")


def test_a_model_that_failed_is_not_loaded_again() -> None:
    load = Inference("load", "m", 0, 0, 0)
    recording: Any = SimpleNamespace(inferences=[load], name="format_raises_pickle")
    require_kept(recording)
    recording.inferences = [load, load]
    with pytest.raises(CheckFailed, match="loaded again"):
        require_kept(recording)
