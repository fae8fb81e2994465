"""Scores as CSV: for a spreadsheet, for Canvas, for Moodle.

Held and missing gradings are empty cells, never zeros.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from grader.classroom.results.clean import cell
from grader.classroom.results.marks import (
    Task,
    checks_of,
    is_graded,
    is_held,
    points_of,
    raw_points,
    why_held,
)
from grader.classroom.row import GRADED, StoredResult

Cell = str | float | int | None

SCORES = (
    "student", "exercise", "state", "points", "max_points", "score", "max_score", "field_ready",
    "passed", "failed", "skipped", "attempts", "wall_s", "cpu_s", "finished", "problem",
)  # fmt: skip


def scores_csv(results: Sequence[StoredResult], tasks: Sequence[Task]) -> str:
    """Return one line per grading, with every figure."""
    by_slug = {task.slug: task for task in tasks}
    rows = [_scores_row(result, by_slug[result.exercise]) for result in results]
    return _text([SCORES, *rows])


def canvas_csv(results: Sequence[StoredResult], tasks: Sequence[Task]) -> str:
    """Return the gradebook as Canvas imports it.

    Source: Canvas Instructor Guide, "How do I import grades in the Gradebook?": the columns
    Student, ID, SIS Login ID and Section, then one per assignment, and below the headings a row
    that begins with "Points Possible". Canvas matches a student by ID or SIS Login ID; here the
    latter is the submission's name. It matches an assignment by its title, or by "Title (id)".
    """
    header: list[Cell] = ["Student", "ID", "SIS Login ID", "Section"]
    header += [task.title for task in tasks]
    possible: list[Cell] = ["    Points Possible", None, None, None]
    possible += [task.points for task in tasks]
    rows = [[name, None, name, None, *points] for name, points in _table(results, tasks)]
    return _text([header, possible, *rows])


def moodle_csv(results: Sequence[StoredResult], tasks: Sequence[Task]) -> str:
    """Return the grades as Moodle imports them.

    Source: Moodle documentation, "Grade import" (CSV import): headings are free; the import maps
    `username` to the user's field and each exercise to its grade item. There are no feedback
    columns, since Moodle would overwrite what teachers wrote.
    """
    header: list[Cell] = ["username", *(task.title for task in tasks)]
    rows = [[name, *points] for name, points in _table(results, tasks)]
    return _text([header, *rows])


def _table(
    results: Sequence[StoredResult], tasks: Sequence[Task]
) -> Iterable[tuple[str, list[Cell]]]:
    found = {(result.student, result.exercise): result for result in results}
    for student in sorted({result.student for result in results}):
        points: list[Cell] = []
        for task in tasks:
            result = found.get((student, task.slug))
            points.append(None if result is None else points_of(result, task))
        if any(value is not None for value in points):  # else there is nothing to import
            yield student, points


def _scores_row(result: StoredResult, task: Task) -> list[Cell]:
    held = is_held(result)
    score, most = raw_points(result) if is_graded(result) else (None, None)
    core = [check for check in checks_of(result) if check.get("kind") != "field"]
    counts = [sum(c.get("outcome") == o for c in core) for o in ("pass", "fail", "skip")]
    ready = (result.grading or {}).get("field_ready")
    state = "held" if held else result.state
    return [
        result.student,
        result.exercise,
        state,
        points_of(result, task),
        task.points,
        score,
        most,
        "" if ready is None else "yes" if ready else "no",
        *(counts if result.state == GRADED and result.grading else (None, None, None)),
        result.attempts,
        round(result.wall_s, 2),
        round(result.cpu_s, 2),
        result.finished,
        why_held(result).reason if held else result.problem,
    ]


def _text(rows: Iterable[Sequence[Cell]]) -> str:
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\r\n")  # RFC 4180
    for row in rows:
        writer.writerow([_written(value) for value in row])
    return target.getvalue()


def _written(value: Cell) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        # Canvas looks for this very cell, with its spaces
        return value if value == "    Points Possible" else cell(value)
    return f"{value:g}" if abs(value) < 1e5 else str(value)
