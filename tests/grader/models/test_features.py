"""Features against a slow, obvious computation."""

import math

import numpy as np
import pytest

from grader.models.features import features, possible_features, scan_features
from grader.recording import Scan

DEGREES = np.arange(-180.0, 180.0)


def slow_features(ranges: np.ndarray, low: float, high: float) -> list[float]:
    sectors: dict[str, list[float]] = {"front": [], "left": [], "right": []}
    for degrees, reading in zip(DEGREES, ranges, strict=True):
        value = low if reading == -math.inf else reading
        if math.isnan(value) or value < low:
            continue
        side = "left" if degrees > 0 else "right"
        sectors["front" if abs(degrees) <= 60 else side].append(min(value, high))
    front = sectors["front"]
    return [
        min(front), float(np.mean(front)), float(np.std(front)),
        min(sectors["left"]), min(sectors["right"]),
    ]  # fmt: skip


@pytest.mark.parametrize("seed", range(5))
def test_features_are_those_of_the_contract(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ranges = rng.uniform(0.0, 14.0, 360)
    for value in (math.inf, -math.inf, math.nan, 0.0):
        ranges[rng.integers(360, size=20)] = value
    low, high = float(np.float32(0.15)), 12.0
    found = features(ranges[None, :], DEGREES, 0.15, 12.0)[0]
    assert found == pytest.approx(slow_features(ranges, low, high), rel=1e-12)


def test_a_scan_has_its_features_to_the_letter() -> None:
    ranges = np.full(360, 4.0, np.float32)
    ranges[np.abs(DEGREES) == 60] = 1.0
    ranges[DEGREES == 61] = 0.5
    scan = Scan(0.0, 0.0, -math.pi, math.radians(1), 0.15, 12.0, ranges)
    assert set(possible_features(scan)[:, 0]) == {0.5, 1.0, 4.0}  # at the edge of a sector
    found = scan_features(scan)
    assert found[[0, 3, 4]].tolist() == [1.0, 0.5, 4.0]
    assert any(np.allclose(found, row) for row in possible_features(scan))


def test_a_blind_scan_has_no_features() -> None:
    assert np.isnan(features(np.zeros((1, 0)), np.zeros(0), 0.15, 12.0)).all()
    half = np.full((1, 360), 2.0)
    half[0, DEGREES < -60] = math.nan
    found = features(half, DEGREES, 0.15, 12.0)[0]
    assert np.isnan(found).tolist() == [False] * 4 + [True]
    ranges = np.full(360, math.nan, np.float32)
    scan = Scan(0.0, 0.0, -math.pi, math.radians(1), 0.15, 12.0, ranges)
    assert np.isnan(scan_features(scan)).all()
    assert np.isnan(possible_features(scan)).all()
