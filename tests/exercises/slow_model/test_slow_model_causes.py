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
    told = [SimpleNamespace(is_load=False, said=(said,)) for said in (0.4, 0.9)]
    twists = SimpleNamespace(t=np.arange(30.0), linear_x=np.full(30, speed))
    run: Any = SimpleNamespace(
        inferences=told, scenario=load_scenario("slow_leader"), twists=lambda: twists
    )
    assert bool(causes.seen({"slow_leader": run}, ["inference_rate"])) == is_said
