"""Scores for spreadsheets, one line per grading with every figure, and for the gradebooks.

Held and missing gradings are empty cells, never zeros.
"""

from collections.abc import Mapping, Sequence

from grader.classroom.amendments import marks
from grader.classroom.results.options import ResultOptions
from grader.classroom.row import GRADED, StoredResult, as_graded
from grader.lms.book import Book, Mark, StudentRow
from grader.lms.people import LISTED, in_order
from grader.lms.tables import Cell, Verbatim, csv_text

SCORES = (
    "student", "name", "id", "section", "exercise", "state", "points", "max_points", "score",
    "max_score", "before_cap", "field_ready", "passed", "failed", "skipped", "attempts", "wall_s",
    "handed_in", "late", "finished", "problem", "points_as_graded", "changed", "style", "max_style",
)  # fmt: skip


def scores_csv(results: Sequence[StoredResult], students: Mapping[str, StudentRow]) -> str:
    rows = [_row(result, students.get(result.student, StudentRow(""))) for result in results]
    return csv_text([SCORES, *rows])


def mark_of(result: StoredResult, row: StudentRow | None = None) -> Mark:
    """Return what a gradebook needs of a result, as its student may see it."""
    changed = result.amended
    return Mark(
        result.exercise,
        row or StudentRow(result.student),
        marks.points_of(result),
        (*(changed.steps if changed else ()), *filter(None, [marks.cap_of(result)])),
        marks.checks_of(result),
        result.wall_s,
    )


def book_of(results: Sequence[StoredResult], options: ResultOptions) -> Book:
    """Return the class as the gradebooks see it: what was handed in, or has points."""
    entries = [
        mark_of(one, options.students.get(one.student))
        for one in (marks.as_shown(result, options.hidden) for result in results)
        if not marks.is_absent(one)
    ]
    return Book(entries, options.students, options.roster, options.columns)


def _row(result: StoredResult, row: StudentRow) -> list[Cell]:
    handed = row.handed.get(result.exercise)
    ids = row.person.ids
    id_ = next((ids[kind] for kind in in_order(ids, LISTED) if ids[kind]), "")
    score, most, raw = marks.raw_points(result) if marks.is_graded(result) else (None, None, None)
    core = [check for check in marks.checks_of(result) if check.get("kind") != "field"]
    counts = [sum(c.get("outcome") == o for c in core) for o in ("pass", "fail", "skip")]
    ready = (result.grading or {}).get("field_ready")
    return [
        result.student,
        row.person.label,
        Verbatim(id_ or (handed.id if handed else "")),
        row.person.section,
        result.exercise,
        marks.state_of(result),
        marks.points_of(result),
        marks.task_of(result.exercise).points,
        score,
        most,
        raw,
        "" if ready is None else "yes" if ready else "no",
        *(counts if result.state == GRADED and result.grading else (None, None, None)),
        result.attempts,
        round(result.wall_s, 2),
        Verbatim(handed.time if handed else ""),
        "late" if handed and handed.late else "",
        result.finished,
        marks.why_held(result).reason if marks.is_held(result) else result.problem,
        marks.points_of(as_graded(result)) if result.amended else None,
        " ".join(result.amended.steps) if result.amended else "",
        *((result.amended and result.amended.style) or (None, None)),
    ]
