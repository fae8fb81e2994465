"""Noise, dropout, loss and delay, each on its own."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.faults import deliveries, measured, sensor_rng, speckle, survivors
from sim.scenario import Faults

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)
RANGES = np.full(20_000, 2.0)
TIMES = np.arange(1, 10_001) * 100_000_000


def rng(sensor="lidar"):
    return sensor_rng(1, sensor)


def test_without_faults_nothing_changes_and_nothing_is_drawn():
    generator = rng()
    assert measured(RANGES, Faults(), generator) is RANGES
    readings = RANGES.astype(np.float32)
    assert speckle(readings, Faults(), generator) is readings
    assert generator.random() == rng().random()


def test_noise_has_its_standard_deviation():
    found = measured(RANGES, Faults(range_noise=0.05), rng())
    assert found.mean() == pytest.approx(2.0, abs=0.002)
    assert found.std() == pytest.approx(0.05, rel=0.05)


def test_noise_makes_no_range_negative_and_no_echo_of_nothing():
    found = measured(np.array([0.001] * 50 + [math.inf]), Faults(range_noise=1.0), rng())
    assert found.min() == 0.0
    assert np.isinf(found).nonzero()[0].tolist() == [50]


def test_a_dropped_beam_sees_nothing_and_a_speckle_is_nan():
    found = measured(RANGES, Faults(beam_dropout=0.2), rng())
    assert np.isinf(found).mean() == pytest.approx(0.2, abs=0.02)
    readings = speckle(RANGES.astype(np.float32), Faults(nan_speckle=0.1), rng())
    assert readings.dtype == np.float32
    assert np.isnan(readings).mean() == pytest.approx(0.1, abs=0.02)


def test_loss_and_blackout():
    arrives = survivors(TIMES, 0.2, rng(), ())
    assert arrives.mean() == pytest.approx(0.8, abs=0.02)
    dark = survivors(TIMES, 0.0, rng(), ((1.0, 2.0),))
    assert (TIMES[~dark] / 1e9).tolist() == pytest.approx(np.arange(10, 21) / 10)


@SETTINGS
@given(st.floats(0, 2), st.floats(0, 2), st.integers(0, 99))
def test_messages_never_overtake_each_other(latency, jitter, seed):
    late = deliveries(TIMES[:200], latency, jitter, np.random.default_rng(seed))
    assert (np.diff(late) >= 0).all()
    wait = late - TIMES[:200]
    assert wait.min() >= round(latency * 1e9)
    assert wait.max() <= round(latency * 1e9) + jitter * 1e9 + 1


def test_every_sensor_has_a_generator_of_its_own():
    assert rng("lidar").random() == rng("lidar").random()
    assert rng("lidar").random() != rng("odometry").random()
    assert sensor_rng(1, "lidar").random() != sensor_rng(2, "lidar").random()
