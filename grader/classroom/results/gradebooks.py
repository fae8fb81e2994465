"""Scores for spreadsheets, and in the form of `nbgrader export`.

Held and missing gradings are empty cells, never zeros.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.classroom.results.gradebook import Book, Mark
from grader.classroom.results.marks import (
    Task,
    checks_of,
    is_graded,
    is_held,
    points_of,
    raw_points,
    state_of,
    why_held,
)
from grader.classroom.results.tables import Cell, Verbatim, csv_text
from grader.classroom.row import GRADED, StoredResult, StudentRow, as_graded

SCORES = (
    "student", "name", "id", "section", "exercise", "state", "points", "max_points", "score",
    "max_score", "field_ready", "passed", "failed", "skipped", "attempts", "wall_s", "cpu_s",
    "handed_in", "late", "finished", "problem", "points_as_graded", "changed",
)  # fmt: skip
ID_FIRST = ("canvas", "id", "idnumber", "sis", "login", "email", "github")
NBGRADER = (
    "assignment", "duedate", "timestamp", "student_id", "last_name", "first_name", "email",
    "raw_score", "late_submission_penalty", "score", "max_score",
)  # fmt: skip


def scores_csv(
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    students: Mapping[str, StudentRow] | None = None,
) -> str:
    """Return one line per grading, with every figure."""
    by_slug = {task.slug: task for task in tasks}
    known = students or {}
    rows = [
        _scores_row(
            result, by_slug[result.exercise], known.get(result.student, StudentRow(result.student))
        )
        for result in results
    ]
    return csv_text([SCORES, *rows])


def nbgrader_csv(book: Book, tasks: Sequence[Task]) -> str:
    """Return the points as nbgrader exports them.

    Source: jupyter/nbgrader, nbgrader/plugins/export.py, `CsvExportPlugin`. Unlike there, who
    handed in nothing has no row: a zero would be a score.
    """
    rows: list[Sequence[Cell]] = [NBGRADER]
    for task in tasks:
        for mark in book.marks(task):
            handed = mark.handed(task.slug)
            first, _, last = mark.name.rpartition(" ")
            rows.append(
                [task.slug, None, Verbatim(handed.time), Verbatim(nbgrader_id(mark, task)),
                 last, first, Verbatim(mark.row.ids.get("email", "")),
                 mark.points + mark.penalty, mark.penalty, mark.points, task.points]
            )  # fmt: skip
    return csv_text(rows)


def nbgrader_id(mark: Mark, task: Task) -> str:
    """Return what nbgrader calls a student."""
    handed = mark.handed(task.slug)
    id_ = handed.id if handed.system == "nbgrader" else mark.row.ids.get("login", "")
    return id_ or mark.student


def write_into_nbgrader(db: Path, book: Book, tasks: Sequence[Task]) -> None:
    """Write the points into nbgrader's own gradebook."""
    from grader.nbgrader.class_scores import Score, write_scores  # noqa: PLC0415  (an extra)

    scores = [
        Score(
            nbgrader_id(mark, task), task.slug, mark.points, task.points, mark.row.name,
            mark.row.ids.get("email", ""),
        )
        for task in tasks
        for mark in book.marks(task)
    ]  # fmt: skip
    write_scores(db, scores)


def _id(row: StudentRow) -> str:
    """Return the id that the instructor's lists most likely have."""
    return next((row.ids[kind] for kind in ID_FIRST if row.ids.get(kind)), "")


def _scores_row(result: StoredResult, task: Task, row: StudentRow) -> list[Cell]:
    held = is_held(result)
    handed = row.handed.get(result.exercise)
    score, most = raw_points(result) if is_graded(result) else (None, None)
    core = [check for check in checks_of(result) if check.get("kind") != "field"]
    counts = [sum(c.get("outcome") == o for c in core) for o in ("pass", "fail", "skip")]
    ready = (result.grading or {}).get("field_ready")
    return [
        result.student,
        row.name,
        Verbatim(_id(row) or (handed.id if handed else "")),
        row.section,
        result.exercise,
        state_of(result),
        points_of(result, task),
        task.points,
        score,
        most,
        "" if ready is None else "yes" if ready else "no",
        *(counts if result.state == GRADED and result.grading else (None, None, None)),
        result.attempts,
        round(result.wall_s, 2),
        round(result.cpu_s, 2),
        Verbatim(handed.time if handed else ""),
        "late" if handed and handed.late else "",
        result.finished,
        why_held(result).reason if held else result.problem,
        points_of(as_graded(result), task) if result.amended else None,
        " ".join(result.amended.steps) if result.amended else "",
    ]
