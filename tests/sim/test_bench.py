"""Which beams the patches of a bench scan cover."""

import math

import numpy as np
import pytest

from sim.bench import BenchScan, Patch, bench_ranges
from sim.lidar import PROFILES


def covered(profile, from_deg, to_deg):
    angles = PROFILES[profile].angles
    ranges = bench_ranges(BenchScan(patches=(Patch(from_deg, to_deg, 1.0),)), angles)
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
    ranges = bench_ranges(scan, PROFILES["default"].angles)
    assert ranges[179] == 2.0
    assert math.isnan(ranges[180])
    assert ranges[0] == 5.0


def test_an_empty_scan_has_no_beams():
    assert bench_ranges(BenchScan(empty=True), PROFILES["wide"].angles).shape == (0,)
