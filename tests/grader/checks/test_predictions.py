"""Which speeds are right when a model predicts them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from grader.checks.predictions import (
    Prediction,
    max_speed,
    predictions,
    right_speeds,
)
from grader.models.files import probe
from grader.recording import Scan
from sim.scenario import Model, NodeSpec


def scan(readings: dict[int, float], elsewhere: float = 2.0) -> Scan:
    """360 beams, one a degree from -180° on; these angles [°] read these distances [m]."""
    ranges = [readings.get(angle, elsewhere) for angle in range(-180, 180)]
    return Scan(0.0, 0.0, -math.pi, math.radians(1), 0.12, 3.5, np.array(ranges, np.float32))


EVERYWHERE = scan({})
BLIND = scan({}, elsewhere=math.nan)
AT_THE_EDGE = scan({60: 1.0})  # ahead or left, who knows


def test_a_beam_at_a_sectors_edge_may_count_on_either_side() -> None:
    model = probe(Model("echo", {"feature": 0.0, "scale": 0.1}))
    found = right_speeds(model, AT_THE_EDGE, 0.5)

    assert (found.low, found.high) == pytest.approx((0.1, 0.2))
    speeds = (0.15, 0.20005, 0.2002, math.nan)
    assert [found.allows(speed, 1e-4) for speed in speeds] == [True, True, False, False]


def fake(scans: tuple[Scan, ...], **settings: float) -> SimpleNamespace:
    models = {"velocity_model.pkl": Model("slow", dict(settings))}
    node = NodeSpec(parameters={"max_speed": 0.15}, models=models)
    return SimpleNamespace(scenario=SimpleNamespace(node=node), scans=lambda: scans)


def test_each_scan_has_its_prediction() -> None:
    recording = fake((EVERYWHERE, BLIND, AT_THE_EDGE), seconds=60.0, scale=0.05)
    assert max_speed(recording.scenario) == 0.15
    whole, none, between = predictions(recording)

    assert [whole.allows(speed) for speed in (0.1, 0.1001, 0.0)] == [True, False, False]
    assert [none.allows(speed) for speed in (0.0, 0.1)] == [True, False]
    assert [between.allows(speed) for speed in (0.05, 0.1)] == [True, True]
    assert not none.exists
    assert none.text == "0.0000 m/s (there is no prediction)"
    assert between.text == "0.0500 to 0.1000 m/s"
    either = Prediction(EVERYWHERE, 0.2, 0.2, missing=True)
    assert [either.allows(speed) for speed in (0.0, 0.2, 0.1)] == [True, True, False]
    assert either.text == "0.2000 m/s or 0.0"
