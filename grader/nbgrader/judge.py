"""Have the files that a notebook writes judged."""

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grader.course.beside import MAX_BYTES, beside
from grader.course.exercises import Exercise
from grader.course.students import Seed
from grader.course.submission import read_regular_file
from grader.course.untouched import untouched
from grader.errors import GraderError
from grader.grading.handed_in import grade_files
from grader.grading.withheld import for_students


@dataclass(frozen=True)
class Verdict:
    """What the judge says of one exercise of one student."""

    grading: dict[str, Any] | None  # as `course grade --json -` writes it, for the student to see
    problem: str = ""  # why there is none; a person has to look
    remarks: tuple[str, ...] = ()


def lying_beside(exercise: Exercise, files: dict[str, str], folder: Path) -> Iterator[str]:
    """Add the files beside a notebook of which no cell writes more than a skeleton; yield remarks.

    An editor wrote them, or other code than a magic's.
    """
    for name in exercise.files:
        with contextlib.suppress(OSError):
            lying, own = read_regular_file(folder / name), files.get(name, "").encode()
            if untouched({name: lying}) or lying == own:
                continue
            counts = "cell"
            if not own or untouched({name: own}):
                files[name], counts = lying.decode("utf-8", "replace"), "file"
            yield f"{name} beside the notebook is not what a cell writes; the {counts} counts."


def judge(
    exercise: Exercise,
    files: Mapping[str, str],
    *,
    seed: Seed | None = None,
    folder: Path | None = None,
) -> Verdict:
    """Drive the nodes of `files` (texts by name) and judge them, as `course grade` does.

    What lies in `folder`, the notebook's, comes along as beside any node.
    `CourseExporter` has made sure that other people's code may run on this machine.
    """
    contents = {name: text.encode("utf-8", "replace") for name, text in files.items()}
    for name, path in beside(folder).files.items() if folder else ():
        if name not in (*contents, *exercise.files):  # those are what the cells write
            with contextlib.suppress(OSError):
                contents[name] = read_regular_file(path, MAX_BYTES)
    try:
        grading = grade_files(exercise, contents, seed=seed, trust=True)
        if seed is not None:  # worlds of the student's own stay hidden
            grading = for_students(grading, tuple(files), ("worlds",))
        return Verdict(grading)
    except GraderError as error:
        return Verdict(None, problem=str(error))
