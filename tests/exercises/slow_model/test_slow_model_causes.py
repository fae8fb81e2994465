"""Commands that are neither 0 nor a prediction are said to be so."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.exercises.slow_model import causes
from sim.scenario_files import load_scenario


@pytest.mark.parametrize(
    ("speed", "is_said"), [(0.31, True), (0.4, False), (0.9, False), (0, False)]
)
def test_commands_that_no_model_said(speed: float, is_said: bool) -> None:
    run: Any = SimpleNamespace(
        inferences=[SimpleNamespace(is_load=False, said=(said,)) for said in (0.4, 0.9)],
        scenario=load_scenario("slow_leader"),
        twists=lambda: SimpleNamespace(t=np.arange(30.0), linear_x=np.full(30, speed)),
    )

    found = causes.seen({"slow_leader": run}, ["inference_rate"])

    assert ("30 of 30 commands" in found.text if found else False) == is_said
