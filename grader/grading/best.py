"""One's own best drives beside the reference's: how long, how far from everything, how smooth.

For a program with all points, in the worlds that `[best]` in `exercise.toml` names. It is for the
student's eyes only, and lies in their own state folder (see `grader.grading.attempts`).
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from grader.course.exercises import Exercise
from grader.course.submission import read_regular_file
from grader.grading.attempts import MAX_BYTES, history, replace
from grader.recording import Recording

if TYPE_CHECKING:
    from grader.grading.grading import Grading

FILE = "best.json"
MOVES = 0.01  # [m/s]
DRIVE = 0.5  # [m] less than this is no drive


class Drive(NamedTuple):
    """The figures of a drive."""

    time: float  # [s] until the robot stood for good, or the run was over
    kept: float  # [m] from everything
    jolt: float  # [m/s²] mean change of speed

    def better(self, other: Drive) -> Drive:
        """Return the better of each figure."""
        return Drive(
            min(self.time, other.time), max(self.kept, other.kept), min(self.jolt, other.jolt)
        )

    def __str__(self) -> str:
        return f"{self.time:5.2f} s  {self.kept:5.2f} m  {self.jolt:.2f} m/s²"


def drive_in(recording: Recording) -> Drive | None:
    """Return a drive's figures; None if the robot hardly moved or touched something."""
    truth = recording.truth
    moving = np.flatnonzero(np.abs(truth.v) > MOVES)
    way = float(np.hypot(np.diff(truth.x), np.diff(truth.y)).sum())
    if way < DRIVE or truth.contact.any():
        return None
    time = float(truth.t[moving[-1]]) / 1e9
    jolt = float(np.abs(np.diff(truth.v)).sum()) / time
    return Drive(round(time, 2), round(float(truth.clearance.min()), 2), round(jolt, 2))


def remember_best(grading: Grading) -> None:
    """Keep the best of these drives and those before, if all points are won."""
    named = {each.name: each for each in grading.recordings if each.name in grading.exercise.best}
    drives = {name: drive for name, each in named.items() if (drive := drive_in(each))}
    if not drives or not grading.whole:
        return
    with contextlib.suppress(OSError):
        known = _known()
        for name, drive in drives.items():
            known[name] = drive.better(known.get(name, drive))
        replace(history().with_name(FILE), msgspec.json.encode(known))


def best_table(exercise: Exercise) -> list[str]:
    """Return the table, a line for each world; nothing if no drive is known."""
    known: Mapping[str, Drive] = {}
    with contextlib.suppress(OSError):
        known = _known()
    rows = [name for name in exercise.best if name in known]
    width = max(map(len, rows), default=0)
    return [
        f"  {name:{width}}  {known[name]}   reference {Drive(*exercise.best[name])}"
        for name in rows
    ]


def _known() -> dict[str, Drive]:
    try:
        content = read_regular_file(history().with_name(FILE), MAX_BYTES)
        return msgspec.json.decode(content, type=dict[str, Drive])
    except (OSError, ValueError, RecursionError):
        return {}
