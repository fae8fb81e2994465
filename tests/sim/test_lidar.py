"""Lidar profiles, and the readings that they make of ranges."""

import math

import numpy as np
import pytest

from sim.lidar import PROFILES, bench_readings, readings


@pytest.mark.parametrize(
    ("name", "ahead"), [("default", 180), ("lds01", 0), ("lds02", 0), ("wide", 540)]
)
def test_one_beam_looks_straight_ahead(name, ahead):
    assert PROFILES[name].angles[ahead] == pytest.approx(0.0, abs=1e-12)


def test_readings_of_the_default_lidar_follow_rep_117():
    sent = readings(
        np.array([0.1, 0.15, 1.23449, 1.2346, 12.0, 12.001, math.inf]), PROFILES["default"]
    )
    assert sent.dtype == np.float32
    expected = np.array([-math.inf, 0.15, 1.234, 1.235, 12.0, math.inf, math.inf], np.float32)
    assert np.array_equal(sent, expected)


def test_an_lds_sends_zero_for_nothing_and_for_too_near():
    sent = readings(np.array([0.05, 3.0, 3.6, math.inf]), PROFILES["lds01"])
    assert np.array_equal(sent, np.array([0.0, 3.0, 0.0, 0.0], np.float32))


def test_every_finite_reading_lies_within_the_limits_of_the_message():
    for profile in PROFILES.values():
        near = np.linspace(0, 2 * profile.range_max, 100_001)
        sent = readings(near, profile)
        valid = sent[np.isfinite(sent) & (sent > 0)]
        assert valid.min() >= np.float32(profile.range_min)
        assert valid.max() <= np.float32(profile.range_max)


def test_bench_readings_are_sent_exactly_and_infinities_as_the_profile_does():
    ranges = np.array([0.5, 0.123456, 99.0, math.inf, -math.inf, math.nan])
    sent = bench_readings(ranges, PROFILES["default"])
    assert np.array_equal(sent, ranges.astype(np.float32), equal_nan=True)
    sent = bench_readings(ranges, PROFILES["lds01"])
    assert np.array_equal(sent[3:5], np.zeros(2, np.float32))
    assert sent[2] == np.float32(99.0)
