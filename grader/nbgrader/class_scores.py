"""Write the scores of a graded class into nbgrader's gradebook, an assignment per exercise.

Each exercise becomes an assignment with one notebook and one cell, which has all the points, so
that formgrader and `nbgrader export` show them. Source: nbgrader.api.Gradebook.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grader.errors import InputError
from grader.nbgrader.programs import find_programs

NOTEBOOK = "course_autograde"
CELL = "points"


@dataclass(frozen=True)
class Score:
    """One student's points in one exercise."""

    student: str  # as nbgrader knows them
    assignment: str  # slug of the exercise
    points: float
    max_points: float
    name: str = ""
    email: str = ""


def write_scores(db: Path, scores: Iterable[Score]) -> int:
    """Write scores into the gradebook in this file; return how many.

    Other assignments, other students and manual scores stay as they are.

    Raises
    ------
    InputError
        nbgrader is not installed, or it has an assignment of that name of its own.
    """
    gradebook_of = _gradebook()
    count = 0
    find_programs()
    with warnings.catch_warnings(), gradebook_of(f"sqlite:///{db.resolve()}") as gradebook:
        warnings.simplefilter("ignore")  # SQLAlchemy's, of how nbgrader makes a submission
        for score in scores:
            _prepare(gradebook, score, db)
            _know(gradebook, score)
            gradebook.update_or_create_submission(score.assignment, score.student)
            grade = gradebook.find_grade(CELL, NOTEBOOK, score.assignment, score.student)
            grade.auto_score = score.points
            grade.needs_manual_grade = False
            gradebook.db.commit()
            count += 1
    return count


def check_available() -> None:
    """Make sure, before the work, that scores can be written after it.

    Raises
    ------
    InputError
        nbgrader is not installed.
    """
    _gradebook()


def _gradebook() -> Any:
    try:
        from nbgrader.api import Gradebook  # noqa: PLC0415  (1 s, and an extra)
    except ImportError:
        raise InputError("--nbgrader: nbgrader is not installed; pip install nbgrader") from None
    return Gradebook


def _prepare(gradebook: Any, score: Score, db: Path) -> None:
    """Make the assignment if it is missing."""
    assignment = gradebook.update_or_create_assignment(score.assignment)
    names = {notebook.name for notebook in assignment.notebooks}
    if names - {NOTEBOOK}:
        raise InputError(
            f"{db}: expected to make an assignment {score.assignment!r}, but nbgrader has one of "
            f"its own, with {', '.join(sorted(names))}; give another file to --nbgrader"
        )
    gradebook.update_or_create_notebook(NOTEBOOK, score.assignment)
    gradebook.update_or_create_grade_cell(
        CELL, NOTEBOOK, score.assignment, max_score=score.max_points, cell_type="code"
    )


def _know(gradebook: Any, score: Score) -> None:
    """Enter the student, with a name where nbgrader has none."""
    student = gradebook.update_or_create_student(score.student)
    first, _, last = score.name.rpartition(" ")
    for field, value in (("first_name", first), ("last_name", last), ("email", score.email)):
        if value and not getattr(student, field):
            setattr(student, field, value)
