"""Training data: scans from seeded rooms, with the speed at which an expert would drive.

An instructor's copy asks the expert (`grader.models.expert`). A student's has no expert, but what
the published one said about the scans of some seeds (`practice.npz`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grader.errors import GraderError, InputError
from grader.models.scans import PROFILE, Scans, make_scans

try:
    from grader.models import expert as its_expert
except ImportError:  # a student's copy
    its_expert = None  # type: ignore[assignment]

Floats = NDArray[np.float64]

HAS_EXPERT = its_expert is not None
PRACTICE = Path(__file__).with_name("practice.npz")
ROUNDING = 0.01  # [m] of the nearest readings there


@dataclass(frozen=True, eq=False)
class Dataset:
    """Scans and labels."""

    ranges: NDArray[np.float32]  # (n, 360) [m]
    speed: Floats  # (n,) [m/s]
    room: NDArray[np.int64]  # (n,) of the data set

    def save(self, path: Path) -> None:
        """Write the .npz file that a training script reads."""
        np.savez(
            path,
            ranges=self.ranges,
            speed=self.speed,
            room=self.room,
            angle_min=PROFILE.angle_min,
            angle_increment=PROFILE.angle_increment,
            range_min=PROFILE.range_min,
            range_max=PROFILE.range_max,
        )


@lru_cache(maxsize=8)
def make_dataset(
    rows: int, seed: int, *, blind: bool = True, plain: bool = False, expert: int | None = None
) -> Dataset:
    """Return `rows` labelled scans; the same seeds give the same data.

    Raises InputError: a student's copy has no labels for these scans.
    Raises GraderError: the scans are not those that the labels were written for.

    Parameters
    ----------
    blind, plain
        See `grader.models.scans.make_scans`.
    expert
        The seed of an expert of one's own; None is the published one.
    """
    scans = make_scans(rows, seed, blind=blind, plain=plain)
    if its_expert is not None:
        speed = its_expert.speeds(scans.exact, its_expert.character(expert))
    else:
        speed = recorded(scans, seed, expert)
    return Dataset(scans.ranges, speed.astype(np.float32).astype(float), scans.room)


def recorded(scans: Scans, seed: int, expert: int | None) -> Floats:
    """Return the published expert's answers to these scans (see `make_dataset`)."""
    speeds, nearest = _practice()
    rows, labelled = len(scans.ranges), speeds.get(seed, np.empty(0))
    if expert is not None or rows > len(labelled):
        there = ", ".join(f"{s} ({len(said)} scans)" for s, said in sorted(speeds.items()))
        raise InputError(
            f"seed {seed}, {rows} scans: expected what a student's copy has labels for: {there}"
        )
    if np.abs(scans.exact.min(axis=1) - nearest[seed][:rows]).max() > ROUNDING:
        raise GraderError("this machine makes other scans than those in practice.npz")
    return labelled[:rows]


@lru_cache(maxsize=1)
def _practice() -> tuple[dict[int, Floats], dict[int, Floats]]:
    """Return by seed the speeds [m/s], and the nearest exact reading of each scan [m]."""
    with np.load(PRACTICE) as data:
        found = {name: data[name].astype(float) for name in data.files}
    speeds, nearest = (
        {int(name.removeprefix(kind)): found[name] for name in found if name.startswith(kind)}
        for kind in ("speed", "nearest")
    )
    return speeds, nearest


def baselines(data: Dataset) -> str:
    """Say in a line which errors to beat: those of a model that sees nothing."""
    error = float(np.abs(data.speed - np.median(data.speed)).mean())
    count = len(np.unique(data.room))
    rooms = "one room" if count == 1 else f"{count} rooms"
    standing = 100 * float((data.speed == 0.0).mean())
    return (
        f"{len(data.speed)} scans of {rooms}; in {standing:.0f} % the expert stands still; "
        f"who always says {np.median(data.speed):.2f} m/s errs by {error:.3f} m/s"
    )
