import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.faults import deliveries, is_frozen, measured, sensor_rng, speckle, survivors
from sim.scenario import Faults, scenario_from_toml
from sim.schedule import Kind, schedule

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)
RANGES = np.full(20_000, 2.0)
TIMES = np.arange(1, 10_001) * 100_000_000


def rng(sensor="lidar"):
    return sensor_rng(1, sensor)


def events(text, kind, seed=1):
    scenario = scenario_from_toml('title = "x"\nworld = "open"\n' + text, "x")
    return [event for event in schedule(scenario, seed) if event.kind is kind]


def test_without_faults_nothing_changes_and_nothing_is_drawn():
    generator = rng()
    assert measured(RANGES, Faults(), generator) is RANGES
    readings = RANGES.astype(np.float32)
    assert speckle(readings, Faults(), generator) is readings
    assert generator.random() == rng().random()


def test_noise_has_its_standard_deviation_and_bias_its_size():
    found = measured(RANGES, Faults(range_noise=0.05, range_bias=0.1), rng())
    assert found.mean() == pytest.approx(2.1, abs=0.002)
    assert found.std() == pytest.approx(0.05, rel=0.05)


def test_noise_makes_no_range_negative_and_no_echo_of_nothing():
    found = measured(np.array([0.1, math.inf]), Faults(range_bias=-5.0), rng())
    assert found.tolist() == [0.0, math.inf]


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


def test_frozen_is_between_begin_and_end():
    faults = Faults(freeze=((1.0, 2.0), (5.0, 6.0)))
    frozen = [is_frozen(round(t * 1e9), faults) for t in (0.9, 1.0, 2.0, 2.1, 5.5)]
    assert frozen == [False, True, True, False, True]


def test_every_sensor_has_a_generator_of_its_own():
    assert rng("lidar").random() == rng("lidar").random()
    assert rng("lidar").random() != rng("odometry").random()
    assert sensor_rng(1, "lidar").random() != sensor_rng(2, "lidar").random()


def test_periodic_messages_do_not_drift():
    found = events("duration = 1000\n[odometry]\nrate = 30\nphase = 0.5", Kind.ODOM)
    assert len(found) == 30 * 999 + 15 + 1
    assert found[-1].time == 1000 * 10**9
    assert all(e.time == round((0.5 + e.index / 30) * 1e9) for e in found)


def test_latency_keeps_the_stamp_and_late_messages_miss_the_end():
    found = events("duration = 2\n[faults]\nscan_latency = 0.3", Kind.SCAN)
    assert {e.delivery - e.time for e in found} == {300_000_000}
    assert max(e.delivery for e in found) <= 2 * 10**9
    assert len(found) == 17


def test_lost_scans_are_lost_by_the_seed():
    text = "duration = 100\n[faults]\nscan_loss = 0.2"
    assert len(events(text, Kind.SCAN)) == pytest.approx(800, abs=40)
    assert events(text, Kind.SCAN) == events(text, Kind.SCAN)
    assert events(text, Kind.SCAN) != events(text, Kind.SCAN, seed=2)
    assert events(text, Kind.ODOM) == events("duration = 100", Kind.ODOM)


def test_lost_scans_use_up_no_bench_entry():
    text = 'duration = 9\n[faults]\nscan_loss = 0.5\n[[bench]]\nlabel = "a"\nrepeat = 7'
    assert [e.index for e in events(text, Kind.SCAN)] == list(range(7))


def test_sensors_can_be_switched_off():
    off = "[lidar]\nenabled = false\n[odometry]\nenabled = false"
    assert not events(off, Kind.SCAN)
    assert not events(off, Kind.ODOM)
