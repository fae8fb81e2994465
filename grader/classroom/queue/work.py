"""Grade one unit: what a worker process does, on this machine or another.

A unit carries all that it needs and can be pickled. Nothing here raises because of a submission:
whatever happens becomes a result or its `problem`.
"""

import contextlib
import ctypes
import gc
import io
import os
import tarfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grader.classroom.row import UNJUDGED
from grader.course.exercises import Exercise, find_exercise
from grader.course.students import Seed
from grader.errors import is_disk_full
from grader.grading.grading import grade
from grader.grading.handed_in import grade_files, reason_of
from rclpy_virtual_time import fresh_folder

MOST_SENT = 96 * 2**20  # [bytes] of recordings sent back; exercise 3 with --field: 41 MiB
UNIT_LIMIT = 2 * 3600.0  # [s] after which a worker exits; trials end long before that


@dataclass(frozen=True)
class Unit:
    """One student's files for one exercise, and how they are to be graded."""

    student: str
    exercise: str  # slug
    files: dict[str, bytes]
    seed: Seed | None = None
    field: bool = False
    bags: bool = True  # record every trial
    bag_folder: str = ""  # where bags go; "": they are sent back, packed
    saved: str = ""  # judge the bags in this folder; no student's code runs
    trust: bool = False  # run it even where isolation is too weak
    canary: bool = False
    alone: bool = False  # with no other unit running

    @property
    def key(self) -> tuple[str, str]:
        return self.student, self.exercise


@dataclass(frozen=True)
class UnitResult:
    """The outcome of a unit."""

    grading: dict[str, Any] | None
    problem: str = ""  # why there is no grading; never the student's fault
    disk_full: bool = False  # that is why
    died: bool = False  # so is the end of the worker
    bags: bytes = b""  # a tar file, if the unit named no folder; b"": too large
    wall_s: float = 0.0  # [s]


_one_at_a_time = threading.Lock()


def grade_unit(unit: Unit) -> UnitResult:
    """Grade a unit; two at a time in one process wait for each other."""
    with _one_at_a_time, _time_limit(UNIT_LIMIT):
        start = time.monotonic()
        result = _grade(unit)
        _free_memory()
        return replace(result, wall_s=time.monotonic() - start)


def unjudged(grading: dict[str, Any]) -> str:
    """Say which checks could not judge, so that a person has to; "" if all could."""
    bad = [c for c in grading["checks"] if c["outcome"] in ("error", "inconclusive")]
    if not bad:
        return ""
    return f"{UNJUDGED} {', '.join(c['id'] for c in bad)}: {bad[0]['message']}"


def stalled(grading: dict[str, Any] | None) -> bool:
    """Return whether the machine's stalls are all that kept checks from judging."""
    outcomes = {check["outcome"] for check in grading["checks"]} if grading else set()
    return "inconclusive" in outcomes and "error" not in outcomes


def _grade(unit: Unit) -> UnitResult:
    try:
        exercise = find_exercise(unit.exercise)
        if unit.saved:
            return UnitResult(_judge_saved(exercise, unit))
        with contextlib.ExitStack() as stack:
            here = Path(unit.bag_folder) if unit.bag_folder else None
            folder = here or stack.enter_context(fresh_folder())
            grading = grade_files(
                exercise,
                unit.files,
                seed=unit.seed,
                field=unit.field,
                bags=folder if unit.bags else None,
                trust=unit.trust,
            )
            packed = b"" if here or not unit.bags else _packed(folder)
        return UnitResult(_portable(grading), bags=packed)
    except Exception as error:  # the grader's own fault costs a student nothing, nor the class
        return UnitResult(None, reason_of(error), disk_full=is_disk_full(error))


def _judge_saved(exercise: Exercise, unit: Unit) -> dict[str, Any]:
    from grader.recording.bag import load_all  # noqa: PLC0415
    from grader.trial.trials import SavedTrials  # noqa: PLC0415

    trials = SavedTrials(load_all(Path(unit.saved)))
    first = exercise.files[0]
    return _portable(grade(exercise, trials, file=first, field=unit.field).as_dict())


def _portable(grading: dict[str, Any]) -> dict[str, Any]:
    """Return the grading with no path of the machine that made it."""
    for recording in grading["recordings"]:
        if recording["bag"]:
            recording["bag"] = Path(recording["bag"]).name
    return grading


def _packed(folder: Path) -> bytes:
    """Return the recordings as a tar file; nothing of a flood's."""
    if sum(path.stat().st_size for path in folder.rglob("*")) > MOST_SENT:
        return b""
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w:gz", compresslevel=1) as archive:
        archive.add(folder, arcname=".")
    return stream.getvalue()


@contextlib.contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    """Exit this process if the block takes longer: a worker that hangs is as good as dead."""
    timer = threading.Timer(seconds, os._exit, (70,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _free_memory() -> None:
    """Free what the last unit left, so that a worker is as big after 500 units as after ten.

    A finished pytest session is a cycle that holds recordings: tens of MiB until Python collects
    it. What the first unit leaves (modules, worlds) is kept, and frozen out of later collections.
    """
    gc.collect()
    if not gc.get_freeze_count():
        gc.freeze()
    with contextlib.suppress(OSError, AttributeError):  # another C library than glibc
        ctypes.CDLL(None).malloc_trim(0)
