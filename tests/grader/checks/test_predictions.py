"""Which speeds are right when a model predicts them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from grader.checks.predictions import (
    Prediction,
    SpeedInterval,
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


@pytest.mark.parametrize(
    ("value", "right"), [(0.3, 0.3), (0.9, 0.5), (-0.2, 0.0), (math.nan, 0.0), (math.inf, 0.0)]
)
def test_what_a_model_predicts_is_clipped(value: float, right: float) -> None:
    model = probe(Model("constant", {"value": value}))
    assert right_speeds(model, EVERYWHERE, 0.5) == SpeedInterval(right, right)


def test_without_model_or_reading_only_zero_is_right() -> None:
    assert right_speeds(None, EVERYWHERE, 0.5) == SpeedInterval(0.0, 0.0)
    model = probe(Model("constant", {"value": 0.3}))
    assert right_speeds(model, BLIND, 0.5) == SpeedInterval(0.0, 0.0)
    raising = probe(Model("raises_near", {"distance": 99.0}))
    assert right_speeds(raising, EVERYWHERE, 0.5) == SpeedInterval(0.0, 0.0)


def test_a_beam_at_a_sectors_edge_may_count_on_either_side() -> None:
    model = probe(Model("echo", {"feature": 0.0, "scale": 0.1}))
    found = right_speeds(model, AT_THE_EDGE, 0.5)

    assert (found.low, found.high) == pytest.approx((0.1, 0.2))
    assert found.allows(0.15, 1e-4)
    assert found.allows(0.20005, 1e-4)
    assert not found.allows(0.2002, 1e-4)
    assert not found.allows(math.nan, 1e-4)


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [(0.25, 0.25, "0.25"), (0.1, 0.1, "0.10"), (0.0, 0.0, "0.00"), (0.1233, 0.1235, "0.1234")],
)
def test_an_interval_is_spelt_as_its_middle(low: float, high: float, text: str) -> None:
    assert str(SpeedInterval(low, high)) == text


def fake(scans: tuple[Scan, ...], **settings: float) -> SimpleNamespace:
    models = {"velocity_model.pkl": Model("slow", dict(settings))}
    node = NodeSpec(parameters={"max_speed": 0.15}, models=models)
    return SimpleNamespace(scenario=SimpleNamespace(node=node), scans=lambda: scans)


def test_each_scan_has_its_prediction() -> None:
    recording = fake((EVERYWHERE, BLIND, AT_THE_EDGE), seconds=60.0, scale=0.05)
    assert max_speed(recording.scenario) == 0.15
    whole, none, between = predictions(recording)

    assert whole.allows(0.1)
    assert not whole.allows(0.1001)
    assert not whole.allows(0.0)
    assert not none.exists
    assert none.allows(0.0)
    assert not none.allows(0.1)
    assert between.allows(0.05)
    assert between.allows(0.1)
    assert none.text == "0.0000 m/s (there is no prediction)"
    assert between.text == "0.0500 to 0.1000 m/s"


def test_where_a_prediction_may_be_missing_zero_is_right_too() -> None:
    either = Prediction(EVERYWHERE, 0.2, 0.2, missing=True)
    assert either.allows(0.0)
    assert either.allows(0.2)
    assert not either.allows(0.1)
    assert either.text == "0.2000 m/s or 0.0"
