"""Which prediction a speed can come from."""

import math
import struct
from types import SimpleNamespace
from typing import Any

import numpy as np

from grader.checks.inferences import Answered
from grader.recording import Inference

SIGNALLING = struct.unpack("<d", bytes.fromhex("010000000000f07f"))[0]  # NaN of IEEE 754-2019, 6.2


def answered(*said: float) -> Answered:
    """A model that was asked at 0, 1, 2 ... s and needed 0.1 s each time."""
    asked = [
        Inference("predict", "m.pkl", n * 10**9, n * 10**9 + 10**8, 10**8, (speed,))
        for n, speed in enumerate(said)
    ]
    scenario = SimpleNamespace(node=SimpleNamespace(parameters={}))  # max_speed is 0.5 m/s
    fake: Any = SimpleNamespace(inferences=asked, scenario=scenario)
    return Answered(fake)


def test_the_newest_question_of_those_answered_in_time() -> None:
    model = answered(0.2, 0.3, 0.2, 9.0)
    assert model.newest_question(9.0, 0.2) == 2.0
    assert model.newest_question(2.05, 0.2) == 0.0
    assert model.newest_question(9.0, 0.5) == 3.0  # clipped
    assert model.newest_question(9.0, 0.4) == -math.inf


def test_a_signalling_nan_was_never_predicted() -> None:
    model = answered(0.2)
    for nan in (math.nan, SIGNALLING):
        assert model.newest_question(9.0, np.float64(nan)) == -math.inf
        assert model.tolerance(np.array([nan, 0.2])) == model.tolerance(np.array([0.2]))
