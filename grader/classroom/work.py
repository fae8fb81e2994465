"""Grade one unit: what a worker process does, on this machine or another.

A unit carries all that it needs and can be pickled. Nothing here raises because of a submission:
whatever happens becomes a result or its `problem`.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import gc
import io
import os
import platform
import tarfile
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grader.classroom.row import StoredResult
from grader.course.exercises import Exercise, find_exercise
from grader.errors import GraderError, InputError
from grader.link.doctor import foreign_code_problem
from grader.link.hosts import ForkServer
from grader.link.pool import ForkServerPool
from grader.link.scratch import prefix

UNIT_LIMIT = 2 * 3600.0  # [s] after which a worker gives itself up; trials end long before
TICK = os.sysconf("SC_CLK_TCK")  # of the times in /proc [1/s]


@dataclass(frozen=True)
class Unit:
    """One student's files for one exercise, and how they are to be graded."""

    student: str
    exercise: str  # slug
    files: dict[str, bytes]
    seed: int | None = None
    field: bool = False
    tier: int = 1
    bags: bool = True  # record every trial
    room: str = ""  # where bags go; "": they are sent back, packed
    saved: str = ""  # judge the bags in this folder; no student's code runs
    trust: bool = False  # run it behind any isolation, or none
    canary: bool = False
    alone: bool = False  # with nothing beside it

    @property
    def key(self) -> tuple[str, str]:
        """What the store calls it."""
        return self.student, self.exercise


@dataclass(frozen=True)
class UnitResult:
    """What came of it."""

    grading: dict[str, Any] | None
    problem: str = ""  # why there is no grading; never the student's fault
    bags: bytes = b""  # a tar file, if there was no room on the same machine
    cpu_s: float = 0.0  # [s] of the worker and all that it started
    wall_s: float = 0.0  # [s]
    worker: str = ""
    memory: int = 0  # [bytes] the worker's, resident


_one_at_a_time = threading.Lock()
_forkservers = ForkServerPool(most=1)  # of this worker, kept between units
atexit.register(_forkservers.close)


def grade_unit(unit: Unit) -> UnitResult:
    """Grade a unit; two at a time in one process wait for each other."""
    with _one_at_a_time, _given_up_after(UNIT_LIMIT):
        start, before = time.monotonic(), cpu_seconds()
        result = _grade(unit)
        _tidy_memory()
        return replace(
            result,
            cpu_s=max(0.0, cpu_seconds() - before),
            wall_s=time.monotonic() - start,
            worker=f"{platform.node()}/{os.getpid()}",
            memory=resident_memory(),
        )


def isolation_problem() -> str:
    """Say why this worker should not run other people's code; "" if it may."""
    with _one_at_a_time:
        try:
            return isolation_is_enough(_forkservers.of())
        except (GraderError, InputError) as error:
            raise GraderError(str(error)) from None


def isolation_is_enough(forkserver: ForkServer) -> str:
    """Say why other people's code should not run in this fork server's hosts; "" if it may."""
    return foreign_code_problem(forkserver.layers)


def cpu_seconds() -> float:
    """Return the CPU time of this process and all below it, dead ones too [s]."""
    return sum(_ticks(pid) for pid in _family(os.getpid())) / TICK


def resident_memory() -> int:
    """Return the resident memory of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def why_held(grading: dict[str, Any]) -> str:
    """Say why a person has to look at a grading; "" if it counts as it is."""
    bad = [c for c in grading["checks"] if c["outcome"] in ("error", "inconclusive")]
    if not bad:
        return ""
    return f"could not judge {', '.join(c['id'] for c in bad)}: {bad[0]['message']}"


def judge_saved(result: StoredResult, folder: Path) -> Unit:
    """Return the unit that judges a result's recordings again."""
    old = result.grading or {}
    return Unit(
        result.student,
        result.exercise,
        {},
        field=any(check["kind"] == "field" for check in old.get("checks", ())),
        tier=int(old.get("tier", 1)),
        saved=str(folder),
    )


def _grade(unit: Unit) -> UnitResult:
    try:
        exercise = find_exercise(unit.exercise)
        if unit.saved:
            return UnitResult(_judge(exercise, unit))
        with contextlib.ExitStack() as stack:
            room = Path(unit.room) if unit.room else _room(stack)
            grading = _run(exercise, unit, room if unit.bags else None)
            packed = b"" if unit.room or not unit.bags else _packed(room)
        return UnitResult(grading, bags=packed)
    except (GraderError, InputError) as error:
        _forkservers.close()
        return UnitResult(None, " ".join(str(error).split()))
    except Exception as error:  # the grader's own fault costs a student nothing, nor the class
        _forkservers.close()
        text = f"the grader failed ({type(error).__name__}: {str(error)[:300]})"
        return UnitResult(None, " ".join(text.split()))


def _run(exercise: Exercise, unit: Unit, bags: Path | None) -> dict[str, Any]:
    from grader.course.submission import find_submission  # noqa: PLC0415
    from grader.grading.grading import grade_submission  # noqa: PLC0415  (pulls the whole judge in)

    forkserver = _forkservers.of(exercise.libraries)
    refusal = "" if unit.trust else isolation_is_enough(forkserver)
    if refusal:
        raise GraderError(refusal)
    with tempfile.TemporaryDirectory(prefix=prefix()) as name:
        folder = Path(name)
        for file, data in unit.files.items():
            (folder / file).write_bytes(data)
        first, *others = exercise.files
        grading = grade_submission(
            exercise,
            find_submission(folder / first, first, others),
            forkserver,
            file=first,
            field=unit.field,
            seed=unit.seed,
            bags=bags,
            tier=unit.tier,
        )
    return _portable(grading.as_dict())


def _judge(exercise: Exercise, unit: Unit) -> dict[str, Any]:
    from grader.grading.grading import grade  # noqa: PLC0415
    from grader.trial.trials import SavedTrials, load_bags  # noqa: PLC0415

    trials = SavedTrials(load_bags(Path(unit.saved)))
    first = exercise.files[0]
    return _portable(
        grade(exercise, trials, file=first, field=unit.field, tier=unit.tier).as_dict()
    )


def _portable(grading: dict[str, Any]) -> dict[str, Any]:
    """Return the grading with no path of the machine that made it."""
    for recording in grading["recordings"]:
        if recording["bag"]:
            recording["bag"] = Path(recording["bag"]).name
    return grading


def _room(stack: contextlib.ExitStack) -> Path:
    return Path(stack.enter_context(tempfile.TemporaryDirectory(prefix=prefix())))


def _packed(folder: Path) -> bytes:
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w:gz", compresslevel=1) as archive:
        archive.add(folder, arcname=".")
    return stream.getvalue()


@contextlib.contextmanager
def _given_up_after(seconds: float) -> Iterator[None]:
    """End this process if the block takes longer: a worker that is stuck is as good as dead."""
    timer = threading.Timer(seconds, os._exit, (70,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _tidy_memory() -> None:
    """Let go of the last unit, so that a worker is as big after 500 units as after ten.

    pytest's sessions end as cycles that hold recordings, tens of MiB before Python looks for them
    by itself. What the first unit leaves (modules, worlds) stays, and is not looked at again.
    """
    gc.collect()
    if not gc.get_freeze_count():
        gc.freeze()
    with contextlib.suppress(OSError, AttributeError):  # another C library than glibc
        ctypes.CDLL(None).malloc_trim(0)


def _family(pid: int) -> list[int]:
    found = [pid]
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += _family(int(child))
    return found


def _ticks(pid: int) -> int:
    """Return the CPU time of a process and of those children that it has waited for."""
    try:
        after_name = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0
    return sum(map(int, after_name[11:15]))
