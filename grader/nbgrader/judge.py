"""Have the files of a notebook judged, one warm fork server for all students."""

from __future__ import annotations

import atexit
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grader.course.exercises import Exercise
from grader.course.submission import find_submission
from grader.errors import GraderError, InputError
from grader.grading.grading import grade_submission
from grader.link.doctor import foreign_code_problem
from grader.link.pool import ForkServerPool
from grader.link.scratch import fresh_folder


@dataclass(frozen=True)
class Verdict:
    """What the judge says of one exercise of one student."""

    grading: dict[str, Any] | None  # as `course grade --json -` writes it
    problem: str = ""  # why there is none: the grader's fault, a person has to look
    missing: str = ""  # why there is none: the student handed nothing in
    remarks: tuple[str, ...] = ()


_one_at_a_time = threading.Lock()
_forkservers = ForkServerPool(most=1)  # kept from one student to the next
atexit.register(_forkservers.close)


def refusal() -> str:
    """Say why other people's code should not run on this machine; "" if it may.

    Raises
    ------
    GraderError
        No node can run here at all.
    """
    with _one_at_a_time:
        return foreign_code_problem(_forkservers.of().layers)


def judge(exercise: Exercise, files: Mapping[str, str], *, seed: int | None = None) -> Verdict:
    """Drive the nodes of `files` (texts by name) and judge them, as `course grade` does."""
    there = [name for name in exercise.files if name in files]
    if not there:
        return Verdict(None, missing=f"expected a cell that begins with %%node {exercise.files[0]}")
    with _one_at_a_time, fresh_folder() as folder:
        for file in there:
            (folder / file).write_bytes(files[file].encode("utf-8", "replace"))
        try:
            return Verdict(_grading(exercise, folder / there[0], seed))
        except (GraderError, InputError) as error:
            said = " ".join(str(error).split())
        except Exception as error:  # the grader's own fault costs a student nothing
            said = " ".join(f"the grader failed ({type(error).__name__}: {error})".split())
        _forkservers.close()
        return Verdict(None, problem=said[:600])


def _grading(exercise: Exercise, file: Path, seed: int | None) -> dict[str, Any]:
    first, *others = exercise.files
    grading = grade_submission(
        exercise,
        find_submission(file, first, others),
        _forkservers.of(exercise.libraries),
        file=file.name,
        seed=seed,
    )
    return grading.as_dict()
