"""Which beams the patches of a bench scan cover."""

import math

import msgspec
import numpy as np
import pytest

from sim.bench import BenchScan, Patch, bench_ranges, varied
from sim.lidar import PROFILES
from sim.scenario_files import load_scenario
from sim.simulation import Simulation


def covered(profile, from_deg, to_deg):
    angles = PROFILES[profile].angles
    ranges = bench_ranges(BenchScan(patches=(Patch(from_deg, to_deg, 1.0),)), PROFILES[profile])
    degrees = np.rint(np.degrees(angles[np.isfinite(ranges)])).astype(int)
    return sorted((degrees + 180) % 360 - 180)


@pytest.mark.parametrize("profile", ["default", "lds01"])
def test_the_ends_of_a_patch_belong_to_it(profile):
    assert covered(profile, -2, 1) == [-2, -1, 0, 1]
    assert covered(profile, 80, 80) == [80]


@pytest.mark.parametrize("profile", ["default", "lds01"])
def test_a_patch_wraps_through_the_back(profile):
    assert covered(profile, 178, -178) == [-180, -179, -178, 178, 179]
    assert covered(profile, 179, 180) == [-180, 179]
    assert covered(profile, -180, -179) == [-180, -179]
    assert covered(profile, -180, 180) == list(range(-180, 180))


def test_later_patches_cover_earlier_ones():
    scan = BenchScan(fill=5.0, patches=(Patch(-90, 90, 2.0), Patch(0, 0, math.nan)))
    ranges = bench_ranges(scan, PROFILES["default"])
    assert ranges[179] == 2.0
    assert math.isnan(ranges[180])
    assert ranges[0] == 5.0


def jittered(scan, seed):
    return bench_ranges(scan, PROFILES["default"], np.random.default_rng(seed))


def test_a_jitter_moves_measurements_and_nothing_else():
    patches = (Patch(-90, 90, 2.0), Patch(0, 0, math.nan), Patch(5, 9, 0.5), Patch(20, 20, 65.5))
    scan = BenchScan(fill=5.0, patches=(*patches, Patch(30, 30, math.inf), Patch(40, 40, 0.05)))
    plain = bench_ranges(scan, PROFILES["default"])
    moved = jittered(scan, 1)

    assert math.isnan(moved[180])
    assert (moved[185:190] == 0.5).all()  # a threshold, sent exactly
    for degrees in (20, 30, 40):  # nothing that was measured
        assert moved[180 + degrees] == plain[180 + degrees]
    front = np.abs(np.arange(-180, 180)) <= 90
    ahead, behind = moved[front & (plain == 2.0)], moved[~front]
    assert np.abs(ahead - 2.0).max() <= 0.008
    assert 4.992 <= behind.min() < 5.0
    assert 5.6 < behind.max() <= 5.76
    assert np.mean(np.abs(behind - 5.0) <= 0.008) == pytest.approx(1 / 3, abs=0.1)


def test_a_jitter_never_leaves_the_lidars_limits_and_belongs_to_its_seed():
    far = BenchScan(fill=11.5)
    assert jittered(far, 1).max() <= 11.95
    assert (jittered(far, 1) == jittered(far, 1)).all()
    assert (jittered(far, 1) != jittered(far, 2)).mean() > 0.5


AHEAD = BenchScan("a box", fill=5.0, patches=(Patch(-5, 5, 0.4), Patch(100, -170, 1.0)))
TURNING = msgspec.structs.replace(AHEAD, turn_deg=(-80, 60))


def test_another_seed_turns_what_may_be_turned_by_whole_degrees():
    seen = set()
    for seed in range(40):
        (scan,) = varied([TURNING], False, np.random.default_rng(seed))
        first, second = scan.patches
        angle = first.from_deg + 5
        assert angle == round(angle)
        assert -80 <= angle <= 60
        assert first == Patch(angle - 5, angle + 5, 0.4)
        assert (second.from_deg - 100 - angle) % 360 == 0
        assert -180 <= second.to_deg < 180
        side = "left" if angle > 0 else "right"
        assert scan.label == (
            f"a box, turned {abs(angle):.0f}° to the {side}" if angle else "a box"
        )
        seen.add(angle)
    assert len(seen) > 20
    assert varied([AHEAD], True, np.random.default_rng(1)) == (AHEAD,)


def test_another_seed_shuffles_where_the_order_does_not_matter():
    bench = [BenchScan(label=str(i)) for i in range(9)]
    for any_order in (False, True):
        scans = varied(bench, any_order, np.random.default_rng(3))
        assert (list(scans) != bench) == any_order
        assert sorted(scan.label for scan in scans) == [scan.label for scan in bench]


def test_a_recording_has_the_bench_as_its_seed_has_it():
    scenario = load_scenario("avoid_zones")
    assert Simulation(scenario).scenario is scenario
    other = Simulation(scenario, 2**63 + 5).scenario
    assert [scan.label for scan in other.bench] != [scan.label for scan in scenario.bench]
    assert len(other.bench_scans) == len(scenario.bench_scans)


def test_a_world_that_was_kept_has_the_bench_of_its_trials_seed():
    """So it shows what a check in other worlds has shown; its own seed would be as written."""
    own = load_scenario("avoid_zones")
    kept = msgspec.structs.replace(own, trial_seed=7)

    assert Simulation(kept).scenario.bench == Simulation(own, 7).scenario.bench != own.bench
