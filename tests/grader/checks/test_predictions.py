"""Which speeds are right when a model predicts them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from grader.checks.case import exactly
from grader.checks.predictions import (
    Prediction,
    max_speed,
    prediction,
    predictions,
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
    assert prediction(model, EVERYWHERE, 0.5).allowed == exactly(right)


def test_without_model_or_reading_only_zero_is_right() -> None:
    assert prediction(None, EVERYWHERE, 0.5).allowed == exactly(0.0)
    model = probe(Model("constant", {"value": 0.3}))
    assert prediction(model, BLIND, 0.5).allowed == exactly(0.0)
    raising = probe(Model("raises_near", {"distance": 99.0}))
    assert prediction(raising, EVERYWHERE, 0.5).allowed == exactly(0.0)


def test_a_beam_at_a_sectors_edge_may_count_on_either_side() -> None:
    model = probe(Model("echo", {"feature": 0.0, "scale": 0.1}))
    found = prediction(model, AT_THE_EDGE, 0.5)

    assert found.allowed == (pytest.approx((0.1, 0.2)),)
    assert found.allows(0.15)
    assert found.allows(0.20004)
    assert not found.allows(0.2001)
    assert not found.allows(math.nan)


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


def test_where_a_prediction_may_be_missing_zero_is_right_too() -> None:
    either = Prediction(EVERYWHERE, 0.2, 0.2, missing=True)
    assert either.allows(0.0)
    assert either.allows(0.2)
    assert not either.allows(0.1)
    assert either.allowed == ((0.0, 0.0), (0.2, 0.2))
