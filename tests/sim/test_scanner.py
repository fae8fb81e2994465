"""The scans that a simulation sends: `sim.scanner`, tested through `sim.simulation`."""

import numpy as np
import pytest
from simulated import SECOND, scans_in, simulate

from sim.lidar import PROFILES
from sim.messages import EPOCH_NS, LASER_SCAN, decode
from sim.scenario_files import scenario_from_toml
from sim.simulation import Simulation


def test_the_lidar_sees_a_cart_where_it_is():
    scenario = scenario_from_toml(
        'title = "x"\n[world]\n[[world.carts]]\nsize = [0.5, 0.5]\npath = [[0, 5, 0], [4, 1, 0]]',
        "x",
    )
    for message in Simulation(scenario).advance(4 * SECOND):
        if message.type == LASER_SCAN:
            ahead = decode(message.data, message.type).ranges[180]
            assert ahead == pytest.approx(5 - message.time / SECOND - 0.25, abs=1e-3)


@pytest.mark.parametrize("name", PROFILES)
def test_every_profile_has_its_form(name):
    profile = PROFILES[name]
    _, messages = simulate(f'[lidar]\nprofile = "{name}"', seconds=2.0, world="hall")
    scans = [m for m in messages if m.type == LASER_SCAN]
    assert len(scans) == pytest.approx(2 * profile.rate, abs=1)
    scan = decode(scans[0].data, LASER_SCAN)
    assert len(scan.ranges) == profile.beams
    assert scan.angle_min == np.float32(profile.angle_min)
    assert scan.scan_time == np.float32(1 / profile.rate)
    ahead = scan.ranges[np.argmin(abs(profile.angles))]
    assert ahead == (6.0 if profile.range_max > 6 else profile.no_return)


def test_a_lidar_may_have_other_limits_than_its_profile():
    _, messages = simulate("[lidar]\nlimits = [0.3, 5.0]", seconds=0.1, world="hall")
    (scan,) = scans_in(messages)
    assert (scan.range_min, scan.range_max) == (np.float32(0.3), 5.0)
    seen = np.array(scan.ranges)
    assert np.isinf(seen[180])  # the wall at 6 m
    assert seen[np.isfinite(seen)].max() <= 5.0


def test_a_bench_is_sent_scan_by_scan():
    text = """
    [[bench]]
    label = "near"
    fill = inf
    patches = [{from_deg = -5, to_deg = 5, range = 0.42}]
    repeat = 2
    [[bench]]
    empty = true
    [faults]
    range_noise = 0.5
    nan_speckle = 0.5
    """
    _, messages = simulate(text)
    scans = [scan.ranges for scan in scans_in(messages)]
    assert [len(scan) for scan in scans] == [360, 360, 0]
    assert scans[0][175:186].tolist() == [np.float32(0.42)] * 11
    assert np.isposinf(np.delete(scans[0], range(175, 186))).all()
    assert np.array_equal(scans[0], scans[1])


def test_the_clock_of_a_bench_can_be_set():
    text = """
    [[bench]]
    fill = 2.0
    [[bench]]
    stamp_offset = -5.0
    repeat = 2
    [[bench]]
    fill = 2.0
    """
    _, messages = simulate(text)
    scans = scans_in(messages)
    stamps = [scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9 for scan in scans]
    times = [m.time / 1e9 for m in messages if m.type == LASER_SCAN]
    start = EPOCH_NS / 1e9
    np.testing.assert_allclose(np.subtract(stamps, start), np.add(times, [0, -5, -5, 0]), atol=1e-6)
