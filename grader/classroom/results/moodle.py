"""Points and feedback for Moodle: grade import, grading worksheet, feedback files.

Sources in moodle/moodle:

- grade/import/csv/classes/load_data.php: the instructor maps columns to user fields and grade
  items. One unknown user ends the whole import, and a blank grade removes one. With the column
  "Last downloaded from this course" Moodle refuses to replace what was graded after the download.
- mod/assign/feedback/offline/importgradeslib.php and locallib.php: the worksheet needs
  `Identifier` ("Participant 4711"), `Grade` and `Last modified (grade)`. Rows are skipped whose
  grade is blank, above the maximum, or older than Moodle's. Columns of feedback replace feedback.
- mod/assign/gradingtable.php, col_grademax: the maximum is minus a scale's number, zero without
  grades.
- mod/assign/feedback/file/importziplib.php: folders `NAME_ID_assignfeedback_file`, split at `_`.
"""

from __future__ import annotations

import zipfile
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import BinaryIO

from grader.classroom.intake import student_id
from grader.classroom.results.clean import folder_name, one_line
from grader.classroom.results.gradebook import Book, Mark, each_sheet, scaled
from grader.classroom.results.marks import Task
from grader.classroom.results.tables import Cell, Verbatim, csv_text
from grader.classroom.roster import Sheet

DOWNLOADED = "last downloaded from this course"
CHANGEABLE = "grade can be changed"
GRADED_AT = "last modified (grade)"
WORKSHEET = ("Identifier", "Full name", "Grade", "Maximum grade", "Last modified (grade)")
USER_FIELDS = {"username": "login", "ID number": "idnumber", "Email address": "email"}
EPOCH = (1980, 1, 1, 0, 0, 0)  # the same results make the same bytes


def grades_csv(book: Book, task: Task) -> str | None:
    """Return one exercise's points for "Grades > Import"; None if nobody can be identified."""
    marks = book.marks(task)
    most = _maximum(book, task)
    if _is_scale(most):
        _leave_out_scale(book, f"moodle/{task.folder}.csv", most)
        return None
    locked = [mark for mark in marks if _is_locked(book, mark, task)]
    if locked:
        book.remark(
            f"moodle/{task.folder}.csv leaves out who has a grade that can't be changed",
            [mark.student for mark in locked],
        )
        marks = [mark for mark in marks if mark not in locked]
    known = {mark.student: _user_ids(book, mark, task) for mark in marks}
    if not marks:
        return None
    heading, kind = max(
        USER_FIELDS.items(), key=lambda each: sum(bool(ids.get(each[1])) for ids in known.values())
    )
    sheets = book.sheets("moodle")
    column = book.column([each for each in sheets[0].header if ":" in each], task) if sheets else ""
    times = _times(book, marks, sheets)
    rows: list[list[Cell]] = []
    lost, same = [], []
    count = Counter(ids.get(kind, "") for ids in known.values())
    for mark in marks:
        id_ = known[mark.student].get(kind, "")
        if id_ and count[id_] > 1:
            same.append(mark.student)
            continue
        if not id_ or (times and mark.student not in times):
            lost.append(mark.student)
            continue
        time = [Verbatim(times[mark.student])] if times else []
        rows.append([Verbatim(id_), scaled(mark.points, task, most), *time])
    if same:
        book.remark(f"moodle/{task.folder}.csv leaves out who shares their {heading}", same)
    if not rows:
        return None
    if not most:
        book.remark(
            f"moodle/{task.folder}.csv is out of {task.points:g} points: where the grade item has "
            "another maximum, import the grading worksheet, or give it as a --roster"
        )
    if lost:
        book.remark(f"moodle/{task.folder}.csv leaves out who has no {heading} in the roster", lost)
    header: list[Cell] = [heading, Verbatim(column or book.titles.get(task.slug, task.title))]
    return csv_text([[*header, *(["Last downloaded from this course"] if times else [])], *rows])


def _maximum(book: Book, task: Task) -> str:
    """Return the most that Moodle gives for an exercise, as its worksheet says; "" if none does."""
    here = {mark.handed(task.slug).id for mark in book.marks(task)} - {""}
    for sheet, place in each_sheet(book.sheets("worksheet"), "identifier"):
        small = [heading.casefold() for heading in sheet.header]
        rows = [row for row in sheet.rows if _participant(row[place]) in here]
        if rows and "maximum grade" in small:
            return rows[0][small.index("maximum grade")]
    return ""


def _is_scale(most: str) -> bool:
    """Tell whether an assignment has no points: minus a scale's number is there, or zero."""
    try:
        return bool(most) and not float(most.replace(",", ".")) > 0
    except ValueError:
        return True


def _leave_out_scale(book: Book, name: str, most: str) -> None:
    book.remark(
        f"{name} is not written: the assignment's maximum grade is {one_line(most, 60)!r}, so "
        "Moodle grades it on a scale or not at all; choose points in its settings"
    )


def _is_locked(book: Book, mark: Mark, task: Task) -> bool:
    """Tell whether Moodle's worksheet says that a grade can't be changed."""
    id_ = mark.handed(task.slug).id
    for sheet, place in each_sheet(book.sheets("worksheet"), "identifier"):
        small = [heading.casefold() for heading in sheet.header]
        if id_ and CHANGEABLE in small:
            free = small.index(CHANGEABLE)
            mine = [row for row in sheet.rows if _participant(row[place]) == id_]
            if any(row[free].casefold() == "no" for row in mine):
                return True
    return False


def _user_ids(book: Book, mark: Mark, task: Task) -> Mapping[str, str]:
    """Return a student's ids; without a roster, folders may be called by the user name."""
    return mark.row.ids if book.roster.people else {"login": mark.login(task.slug)}


def worksheet_csv(book: Book, task: Task) -> str | None:
    """Return one exercise's grading worksheet; None if no submission came from Moodle."""
    theirs = [mark for mark in book.marks(task) if mark.handed(task.slug).system == "moodle"]
    by_id = {mark.handed(task.slug).id: mark for mark in theirs}
    if not theirs:
        return None
    if _is_scale(most := _maximum(book, task)):
        _leave_out_scale(book, f"moodle/{task.folder}-worksheet.csv", most)
        return None
    for sheet, place in each_sheet(book.sheets("worksheet"), "identifier"):
        rows = {_participant(row[place]): row for row in sheet.rows}
        if by_id.keys() & rows.keys():
            return _filled_in(book, task, sheet, rows, by_id)
    plain: list[list[Cell]] = [
        [Verbatim(f"Participant {id_}"), mark.name, mark.points, task.points, Verbatim("-")]
        for id_, mark in by_id.items()
    ]
    return csv_text([list(map(Verbatim, WORKSHEET)), *plain])


def _filled_in(
    book: Book,
    task: Task,
    sheet: Sheet,
    rows: Mapping[str, Sequence[str]],
    by_id: Mapping[str, Mark],
) -> str:
    """Return Moodle's own worksheet with the new grades, without its columns of feedback."""
    small = [heading.casefold() for heading in sheet.header]
    end = small.index(GRADED_AT) + 1 if GRADED_AT in small else len(small)
    grade = small.index("grade")
    full = small.index("maximum grade") if "maximum grade" in small else None
    free = small.index(CHANGEABLE) if CHANGEABLE in small else None
    text = [small.index(each) for each in ("full name",) if each in small]
    made: list[list[Cell]] = [list(map(Verbatim, sheet.header[:end]))]
    locked, lost = [], []
    for id_, mark in by_id.items():
        row = rows.get(id_)
        if row is None:
            lost.append(mark.student)
        elif free is not None and row[free].casefold() == "no":
            locked.append(mark.student)
        else:
            most = row[full] if full is not None else ""
            cells: list[Cell] = [
                value if place in text else Verbatim(value) for place, value in enumerate(row[:end])
            ]
            cells[grade] = scaled(mark.points, task, most)
            made.append(cells)
    name = f"moodle/{task.folder}-worksheet.csv leaves out who"
    if lost:
        book.remark(f"{name} is not in {sheet.file.name}", lost)
    if locked:
        book.remark(f"{name} has a grade that can't be changed", locked)
    return csv_text(made)


def write_feedback_zip(target: BinaryIO, marks: Sequence[Mark], task: Task, feedback: Path) -> None:
    """Write one exercise's feedback pages as Moodle takes them back."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for mark in marks:
            page = feedback / folder_name(mark.student) / f"{task.folder}.html"
            if not page.is_file():
                continue
            handed = mark.handed(task.slug)
            name = student_id(handed.name).replace("_", " ")
            folder = f"{name}_{handed.id}_assignfeedback_file"
            info = zipfile.ZipInfo(f"{folder}/{task.folder}.html", EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, page.read_bytes())


def _participant(identifier: str) -> str:
    digits = identifier.rpartition(" ")[2]
    return digits if digits.isdecimal() else identifier


def _times(book: Book, marks: Sequence[Mark], sheets: Sequence[Sheet]) -> dict[str, str]:
    """Return when the grades of each student were downloaded; none if one's is missing."""
    for sheet, place in each_sheet(sheets, DOWNLOADED):
        rows = {mark.student: book.row_of(sheet, mark) for mark in marks}
        return {student: row[place] for student, row in rows.items() if row and row[place]}
    return {}
