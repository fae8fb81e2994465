"""The data to learn from."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from grader.models.dataset import PROFILE, expert_speed, make_dataset
from grader.models.features import features

ACCURACY = 0.03  # [m/s] as exercise 2 asks for


def test_the_same_seed_gives_the_same_data() -> None:
    first, other = make_dataset(150, 3), make_dataset(150, 4)
    make_dataset.cache_clear()
    again = make_dataset(150, 3)
    assert np.array_equal(first.ranges, again.ranges, equal_nan=True)
    assert np.array_equal(first.speed, again.speed)
    assert not np.array_equal(first.speed, other.speed)


@pytest.mark.parametrize(
    ("nearest", "deviation", "left", "right", "speed"),
    [
        (0.2, 0.0, 3.0, 3.0, 0.0),
        (0.3, 0.0, 3.0, 3.0, 0.0),
        (0.6, 0.0, 3.0, 3.0, 0.3),
        (12.0, 0.0, 3.0, 3.0, 0.5),
        (12.0, 0.0, 0.5, 1.0, 0.25),
        (12.0, 0.0, 0.2, 0.2, 0.075),
        (12.0, 1.875, 3.0, 3.0, 0.25),
        (12.0, 5.0, 3.0, 3.0, 0.15),
        (0.6, 1.875, 0.5, 1.0, 0.075),
    ],
)
def test_the_expert_heeds_what_is_ahead_the_sides_and_the_clutter(
    nearest: float, deviation: float, left: float, right: float, speed: float
) -> None:
    row = np.array([[nearest, 2.0, deviation, left, right]])
    assert expert_speed(row)[0] == pytest.approx(speed)


def test_no_two_features_say_the_experts_speed() -> None:
    """Bins of two features, as fine as the data allow, err more than exercise 2 takes."""
    data = make_dataset(1200, 5, blind=False)
    seen = features(data.ranges, np.degrees(PROFILE.angles), PROFILE.range_min, PROFILE.range_max)
    for pair in itertools.combinations(seen.T, 2):
        parts = [np.searchsorted(np.quantile(x, np.linspace(0, 1, 11)[1:-1]), x) for x in pair]
        cell = 10 * parts[0] + parts[1]
        spoken = np.array([np.median(data.speed[cell == k]) for k in np.unique(cell)])
        error = np.abs(data.speed - spoken[np.unique(cell, return_inverse=True)[1]]).mean()
        assert error > ACCURACY


def test_data_hold_what_a_lidar_sends_and_all_speeds() -> None:
    data = make_dataset(600, 1)
    assert data.ranges.dtype == np.float32
    assert np.isnan(data.ranges).any()
    assert np.isposinf(data.ranges).any()
    assert np.isneginf(data.ranges).any()
    seen = features(data.ranges, np.degrees(PROFILE.angles), PROFILE.range_min, PROFILE.range_max)
    blind = np.isnan(seen).any(axis=1)
    assert 0 < blind.sum() < 60
    counts, _ = np.histogram(data.speed, [0.0, 1e-9, 0.25, 0.499, 0.51])
    assert counts.min() > 20


def test_hidden_scans_are_never_blind() -> None:
    data = make_dataset(200, 2, blind=False)
    seen = features(data.ranges, np.degrees(PROFILE.angles), PROFILE.range_min, PROFILE.range_max)
    assert np.isfinite(seen).all()


def test_the_file_holds_what_the_exercise_says(tmp_path: Path) -> None:
    make_dataset(150, 3).save(tmp_path / "train.npz")
    with np.load(tmp_path / "train.npz") as data:
        assert data["ranges"].shape == (150, 360)
        assert data["speed"].shape == (150,)
        assert data["range_max"] == PROFILE.range_max
        angles = data["angle_min"] + data["angle_increment"] * np.arange(360)
    assert np.allclose(angles, PROFILE.angles)
