"""Have the files that a notebook writes judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grader.course.exercises import Exercise
from grader.course.students import Seed
from grader.errors import GraderError
from grader.grading.handed_in import grade_files


@dataclass(frozen=True)
class Verdict:
    """What the judge says of one exercise of one student."""

    grading: dict[str, Any] | None  # as `course grade --json -` writes it
    problem: str = ""  # why there is none: the grader's fault, a person has to look
    missing: str = ""  # why there is none: the student handed nothing in
    remarks: tuple[str, ...] = ()


def judge(exercise: Exercise, files: Mapping[str, str], *, seed: Seed | None = None) -> Verdict:
    """Drive the nodes of `files` (texts by name) and judge them, as `course grade` does.

    `CourseExporter` has made sure that other people's code may run on this machine.
    """
    contents = {
        name: files[name].encode("utf-8", "replace") for name in exercise.files if name in files
    }
    if not contents:
        return Verdict(None, missing=f"expected a cell that begins with %%node {exercise.files[0]}")
    try:
        return Verdict(grade_files(exercise, contents, seed=seed, trust=True))
    except GraderError as error:
        return Verdict(None, problem=str(error))
