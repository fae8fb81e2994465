"""Have the files of a notebook judged, one warm nursery for all students."""

from __future__ import annotations

import atexit
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grader.doctor import foreign_code_problem
from grader.errors import GraderError, InputError
from grader.exercises import Exercise
from grader.grading import grade_submission
from grader.launch import Nursery
from grader.scratch import fresh_folder
from grader.submission import find_submission
from sim.messages import EPOCH_NS


@dataclass(frozen=True)
class Verdict:
    """What the judge says of one exercise of one student."""

    grading: dict[str, Any] | None  # as `course grade --json -` writes it
    problem: str = ""  # why there is none: the grader's fault, a person has to look
    missing: str = ""  # why there is none: the student handed nothing in
    remarks: tuple[str, ...] = ()


@dataclass
class _Kept:
    """What this process keeps from one student to the next."""

    nursery: Nursery | None = None
    libraries: tuple[str, ...] = ()
    lock: threading.Lock = field(default_factory=threading.Lock)


_kept = _Kept()


def refusal() -> str:
    """Say why other people's code should not run on this machine; "" if it may.

    Raises
    ------
    GraderError
        No node can run here at all.
    """
    with _kept.lock:
        return foreign_code_problem(_nursery(()).layers)


def judge(exercise: Exercise, files: Mapping[str, str], *, seed: int | None = None) -> Verdict:
    """Drive the nodes of `files` (texts by name) and judge them, as `course grade` does."""
    there = [name for name in exercise.files if name in files]
    if not there:
        return Verdict(None, missing=f"expected a cell that begins with %%node {exercise.files[0]}")
    with _kept.lock, fresh_folder() as folder:
        for file in there:
            (folder / file).write_bytes(files[file].encode("utf-8", "replace"))
        try:
            return Verdict(_grading(exercise, folder / there[0], seed))
        except (GraderError, InputError) as error:
            said = " ".join(str(error).split())
        except Exception as error:  # the grader's own fault costs a student nothing
            said = " ".join(f"the grader failed ({type(error).__name__}: {error})".split())
        _close()
        return Verdict(None, problem=said[:600])


def _grading(exercise: Exercise, file: Path, seed: int | None) -> dict[str, Any]:
    first, *others = exercise.files
    grading = grade_submission(
        exercise,
        find_submission(file, first, others),
        _nursery(exercise.libraries),
        file=file.name,
        seed=seed,
    )
    return grading.as_dict()


def _nursery(libraries: tuple[str, ...]) -> Nursery:
    if _kept.nursery is None or _kept.libraries != libraries:
        _close()
        _kept.nursery, _kept.libraries = Nursery(EPOCH_NS, libraries=libraries), libraries
    return _kept.nursery


@atexit.register
def _close() -> None:
    nursery, _kept.nursery = _kept.nursery, None
    if nursery is not None:
        nursery.__exit__()
