"""Points for Canvas: "Gradebook > Import", a file per exercise.

Source: instructure/canvas-lms, lib/gradebook_importer.rb. A student is found by `ID`, then by SIS
ids, then by name; an assignment by "Title (id)", then by its title. A blank cell over a score
removes it (`no_change_to_value?`), a cell over "EX" ends the excuse, and a row "Points Possible"
changes the assignment. So there is a file per exercise, which holds only students with points, and
that row only where Canvas has to make the assignment.
"""

from __future__ import annotations

import re

from grader.classroom.results.gradebook import Book, scaled
from grader.classroom.results.marks import Task
from grader.classroom.results.tables import Cell, Verbatim, csv_text, number
from grader.classroom.roster import Sheet

PLAIN = ("Student", "ID", "SIS Login ID", "Section")
UNTOUCHED = {"ex": "excused in Canvas", "n/a": "not assigned to them in Canvas"}
READ_ONLY = "read only"


def canvas_csv(book: Book, task: Task) -> str | None:
    """Return the file of one exercise; None if nobody has an id of Canvas's."""
    sheets = book.sheets("canvas")
    if sheets:
        return _from_sheet(book, task, sheets[0])
    rows: list[list[Cell]] = []
    lost = []
    for mark in book.marks(task):
        handed = mark.handed(task.slug)
        id_ = mark.row.ids.get("canvas") or (handed.id if handed.system == "canvas" else "")
        login = mark.row.ids.get("login", "")
        if not id_ and not login and not book.roster.people:
            login = mark.login(task.slug)
        if id_ or login:
            rows.append([mark.name, _id(id_), _id(login), mark.row.section, mark.points])
        else:
            lost.append(mark.student)
    _lost(book, task, lost)
    possible: list[Cell] = [Verbatim("    Points Possible"), None, None, None, task.points]
    title = Verbatim(book.titles.get(task.slug, task.title))
    header: list[Cell] = [*map(Verbatim, PLAIN), title]
    return csv_text([header, possible, *rows]) if rows else None


def _from_sheet(book: Book, task: Task, sheet: Sheet) -> str | None:
    column = book.column(_assignments(sheet), task)
    if not column:
        book.remark(
            f"Canvas's gradebook has no single column for {task.heading!r}, so importing makes "
            f"one; name it with --column '{task.number or task.slug}=TITLE'"
        )
    elif READ_ONLY in sheet.points.get(column, ""):
        book.remark(f"Canvas's column {column!r} is read only: nothing is exported for it")
        return None
    end = sheet.header.index("Section") + 1 if "Section" in sheet.header else 2
    names = 2 if sheet.header[0].casefold() == "lastname" else 1
    rows: list[list[Cell]] = []
    lost = []
    untouched: dict[str, list[str]] = {}
    for mark in book.marks(task):
        row = book.row_of(sheet, mark)
        if row is None:
            lost.append(mark.student)
            continue
        before = row[sheet.header.index(column)].strip() if column else ""
        if before.casefold() in UNTOUCHED:
            untouched.setdefault(UNTOUCHED[before.casefold()], []).append(mark.student)
            continue
        points = scaled(mark.points, task, sheet.points.get(column, "")) if column else mark.points
        called = [_unquoted(name) for name in row[:names]]
        rows.append([*called, *map(Verbatim, row[names:end]), points])
    _lost(book, task, lost)
    for why, students in untouched.items():
        book.remark(f"canvas/{task.folder}.csv leaves out who is {why}", students)
    header: list[Cell] = [*map(Verbatim, sheet.header[:end]), Verbatim(column or task.title)]
    possible: list[list[Cell]] = []
    if not column:
        blank: list[Cell] = [None] * (end - 1)
        possible = [[Verbatim("    Points Possible"), *blank, task.points]]
    elif points_differ(sheet.points.get(column, ""), task):
        book.remark(
            f"canvas/{task.folder}.csv: points are scaled from {number(task.points)} to the "
            f"{sheet.points[column]} of Canvas's column {column!r}"
        )
    return csv_text([header, *possible, *rows]) if rows else None


def points_differ(most: str, task: Task) -> bool:
    """Tell whether a gradebook's column has other points than the exercise."""
    return scaled(task.points, task, most) != task.points


def _assignments(sheet: Sheet) -> tuple[str, ...]:
    """Return the headings of assignments: those with an id at the end, else all."""
    return tuple(each for each in sheet.header if each.endswith(")")) or sheet.header


def _unquoted(name: str) -> str:
    """Return a name that begins with "=" without what Canvas puts around it."""
    match = re.fullmatch(r'="(.*)"', name, re.DOTALL)
    return match[1] if match else name


def _id(text: str) -> Cell:
    return Verbatim(text) if text else None


def _lost(book: Book, task: Task, students: list[str]) -> None:
    if students:
        book.remark(f"canvas/{task.folder}.csv leaves out who has no row in Canvas", students)
