"""Commands that are not what the model says, and models that are loaded again."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks import model_commands
from grader.checks.inferences import require_kept
from grader.checks.verdict import CheckFailed
from grader.recording import Inference


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
