"""The data to learn from."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from grader.authoring.practice import ROWS, practice
from grader.errors import GraderError, InputError
from grader.models import dataset as judged
from grader.models.dataset import PRACTICE, Dataset, baselines, make_dataset, recorded
from grader.models.features import features
from grader.models.scans import PROFILE, Scans, make_scans

MOST = 2_000_000  # [bytes] of a student's copy for data
LATE = [pytest.param(seed, marks=pytest.mark.long) for seed in ROWS if seed not in (5, 83)]


def seen(data: Dataset) -> np.ndarray:
    degrees = np.degrees(PROFILE.angles)
    return features(data.ranges, degrees, PROFILE.range_min, PROFILE.range_max)


def test_the_same_seed_gives_the_same_data() -> None:
    first, other = make_dataset(150, 3), make_dataset(150, 4)
    make_dataset.cache_clear()
    again = make_dataset(150, 3)
    assert np.array_equal(first.ranges, again.ranges, equal_nan=True)
    assert np.array_equal(first.speed, again.speed)
    assert not np.array_equal(first.speed, other.speed)


@pytest.mark.parametrize("lidar", [{"blind": False}, {"plain": True}])
def test_whatever_the_lidar_does_poses_and_speeds_stay(lidar: dict[str, bool]) -> None:
    assert np.array_equal(make_dataset(150, 3).speed, make_dataset(150, 3, **lidar).speed)


def test_a_hundred_rows_come_from_each_room() -> None:
    data = make_dataset(250, 3)
    assert np.bincount(data.room).tolist() == [100, 100, 50]
    assert np.array_equal(data.speed[:100], make_dataset(100, 3).speed)


def test_data_hold_what_a_lidar_sends_and_all_speeds() -> None:
    data = make_dataset(600, 1)
    assert data.ranges.dtype == np.float32
    assert np.isnan(data.ranges).any()
    assert np.isposinf(data.ranges).any()
    assert np.isneginf(data.ranges).any()
    assert 0 < np.isnan(seen(data)).any(axis=1).sum() < 60  # the blind ones
    counts, _ = np.histogram(data.speed, [0.0, 1e-9, 0.25, 0.499, 0.51])
    assert counts.min() > 20


def test_hidden_scans_are_never_blind() -> None:
    assert np.isfinite(seen(make_dataset(200, 2, blind=False))).all()


def test_the_file_holds_what_the_exercise_says(tmp_path: Path) -> None:
    make_dataset(150, 3).save(tmp_path / "train.npz")
    with np.load(tmp_path / "train.npz") as data:
        assert data["ranges"].shape == (150, 360)
        assert data["speed"].shape == data["room"].shape == (150,)
        assert data["range_max"] == PROFILE.range_max
        angles = data["angle_min"] + data["angle_increment"] * np.arange(360)
    assert np.allclose(angles, PROFILE.angles)


def test_a_line_says_what_is_to_be_beaten() -> None:
    data = make_dataset(200, 3)
    error = np.abs(data.speed - np.median(data.speed)).mean()
    assert baselines(data).startswith("200 scans of 2 rooms; in ")
    assert baselines(data).endswith(f"m/s errs by {error:.3f} m/s")


# --- a student's copy ------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [83, *LATE])
def test_students_have_what_the_published_expert_says(seed: int) -> None:
    """After a change of the expert or the scans: `python -m grader.authoring.practice`."""
    with np.load(PRACTICE) as data:
        for name, made in practice(seed, ROWS[seed]).items():
            assert np.array_equal(data[name], made)


def test_a_students_copy_gives_the_same_data(monkeypatch: pytest.MonkeyPatch) -> None:
    ours = [make_dataset(200, 83, blind=False), make_dataset(200, 5)]
    make_dataset.cache_clear()
    monkeypatch.setattr(judged, "its_expert", None)
    theirs = [make_dataset(200, 83, blind=False), make_dataset(200, 5)]
    for our, their in zip(ours, theirs, strict=True):
        assert np.array_equal(our.speed, their.speed)
    for rows, seed, expert in ((100, 77, None), (2001, 1, None), (100, 1, 5)):
        with pytest.raises(InputError, match="labels for: 1 "):
            make_dataset(rows, seed, expert=expert)
    make_dataset.cache_clear()


def test_labels_of_other_scans_are_refused() -> None:
    scans = make_scans(100, 1, blind=True, plain=False)
    moved = Scans(scans.ranges, scans.exact + 0.02, scans.room)
    with pytest.raises(GraderError, match="other scans"):
        recorded(moved, 1, None)


def test_the_data_fit_into_a_students_copy_and_work_without_the_expert() -> None:
    assert PRACTICE.stat().st_size < MOST
    code = (
        "import sys; sys.modules['grader.models.expert'] = None\n"
        "from grader.models.dataset import HAS_EXPERT, make_dataset\n"
        "assert not HAS_EXPERT and len(make_dataset(100, 1).speed) == 100\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
