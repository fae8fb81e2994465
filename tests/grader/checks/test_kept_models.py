"""A model that has failed is not loaded again."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.inferences import require_kept
from grader.checks.verdict import CheckFailed
from grader.recording import Inference


def test_a_model_that_failed_is_not_loaded_again() -> None:
    load = Inference("load", "m", 0, 0, 0)
    recording: Any = SimpleNamespace(inferences=[load], name="format_raises_pickle")
    require_kept(recording)
    recording.inferences = [load, load]
    with pytest.raises(CheckFailed, match="loaded again"):
        require_kept(recording)
