"""Moodle: a folder per student, grade import, grading worksheet, feedback files.

Sources, in moodle/moodle:

- mod/assign/classes/downloader.php (`get_student_prefix`, `load_submissionplugin_filelist`):
  `FULLNAME_ID_assignsubmission_file`, with `_` in the name turned into a space, then the student's
  folders and files, or `_FILENAME` if "Download submissions in folders" is off; up to Moodle 4.0 a
  folder ended in `_`. The id is that of the participant in this one assignment, as in its grading
  worksheet. Group submissions are `GROUP_ID_assignsubmission_file`.
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

import re
import zipfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from grader.lms.book import Book, Mark, Task, scaled
from grader.lms.clean import one_line
from grader.lms.names import student_id
from grader.lms.people import Sheet
from grader.lms.platform import Entry, Files, Platform, Read, Who
from grader.lms.tables import Cell, Verbatim, csv_text

_WHO = r"(?P<name>[^_]+)_(?P<id>\d+)_assignsubmission_(?P<plugin>file|onlinetext)"
FOLDER = re.compile(rf"{_WHO}_?")
FLAT = re.compile(rf"{_WHO}_(?P<file>.+)", re.DOTALL)

TIMES = ("%A, %d %B %Y, %I:%M %p", "%A, %d %B %Y, %H:%M")  # as Moodle writes them in English

DOWNLOADED = "Last downloaded from this course"
IDENTIFIER, GRADE, MOST = "identifier", "grade", "maximum grade"
CHANGEABLE, GRADED_AT = "grade can be changed", "last modified (grade)"
WORKSHEET = ("Identifier", "Full name", "Grade", "Maximum grade", "Last modified (grade)")
LOCKED = "has a grade that can't be changed"
USER_FIELDS = {"username": "login", "ID number": "idnumber", "Email address": "email"}
EPOCH = (1980, 1, 1, 0, 0, 0)  # the same results make the same bytes


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return folders and files with Moodle's prefix."""
    found = Read()
    for path in paths:
        match = (FOLDER if path.is_dir() else FLAT).fullmatch(path.name)
        if match is None or path.is_symlink():
            found.left.append(path)
        else:
            called = "" if path.is_dir() else match["file"]
            found.entries.append(Entry(path, Who(match["name"], "moodle", match["id"]), called))
    return found


def sheet(header: Sequence[str]) -> str:
    """Return the kind of a grading worksheet, or of a gradebook's export."""
    if {IDENTIFIER, GRADE} <= set(header):
        return "worksheet"
    named = {"first name", "last name", "surname", "full name", "name"} & set(header)
    exported = DOWNLOADED.casefold() in header or ("id number" in header and named)
    return "moodle" if exported else ""


def gradebook(book: Book, tasks: Sequence[Task]) -> Files:
    """Return a file per exercise for "Grades > Import", and a grading worksheet."""
    if not book.may_be("moodle", "worksheet"):
        return {}
    files = {}
    for task in tasks:
        files[f"moodle/{task.slug}.csv"] = grades_csv(book, task)
        files[f"moodle/{task.slug}-worksheet.csv"] = worksheet_csv(book, task)
    return {name: text for name, text in files.items() if text}


@dataclass(frozen=True)
class _Worksheet:
    """An assignment's grading worksheet."""

    sheet: Sheet
    rows: Mapping[str, Sequence[str]]  # by participant

    def cell(self, participant: str, heading: str) -> str:
        """Return what is there; "" if nothing is."""
        return self.sheet.cell(self.rows.get(participant), heading)

    def is_locked(self, mark: Mark) -> bool:
        """Return whether a grade can't be changed."""
        return self.cell(mark.handed.id, CHANGEABLE).casefold() == "no"


def _worksheet(book: Book, task: Task) -> _Worksheet | None:
    """Return the roster's worksheet of an exercise, by who is in it."""
    here = {mark.handed.id for mark, _ in book.marks(task)} - {""}
    for sheet_ in book.sheets("worksheet"):
        rows = {_participant(sheet_.cell(row, IDENTIFIER)): row for row in sheet_.rows}
        if here & rows.keys():
            return _Worksheet(sheet_, {id_: rows[id_] for id_ in here if id_ in rows})
    return None


def _participant(identifier: str) -> str:
    digits = identifier.rpartition(" ")[2]
    return digits if digits.isdecimal() else identifier


def _maximum(worksheet: _Worksheet | None) -> str:
    """Return the most that Moodle gives, as its worksheet says; "" if it doesn't."""
    return worksheet.cell(next(iter(worksheet.rows)), MOST) if worksheet else ""


def _is_scale(book: Book, file: str, most: str) -> bool:
    """Return whether an assignment has no points: minus a scale's number is there, or zero."""
    try:
        points = not most or float(most.replace(",", ".")) > 0
    except ValueError:
        points = False
    if not points:
        book.remark(
            f"{file} is not written: the assignment's maximum grade is {one_line(most, 60)!r}, so "
            "Moodle grades it on a scale or not at all; choose points in its settings"
        )
    return not points


def grades_csv(book: Book, task: Task) -> str | None:
    """Return one exercise's points for "Grades > Import"; None if nobody can be identified."""
    file, worksheet = f"moodle/{task.slug}.csv", _worksheet(book, task)
    most = _maximum(worksheet)
    if _is_scale(book, file, most):
        return None
    every = book.marks(task)
    locked = [mark for mark, _ in every if worksheet and worksheet.is_locked(mark)]
    book.leaves_out(file, LOCKED, locked)
    known = {
        mark.student: mark.row.person.ids if book.roster.people else {"login": mark.login}
        for mark, _ in every
        if mark not in locked
    }
    heading, kind = max(
        USER_FIELDS.items(), key=lambda each: sum(bool(ids.get(each[1])) for ids in known.values())
    )
    sheets = book.sheets("moodle")
    column = book.column([each for each in sheets[0].header if ":" in each], task) if sheets else ""
    times = _times(book, [mark for mark, _ in every], sheets)
    rows: list[list[Cell]] = []
    lost, same = [], []
    count = Counter(ids.get(kind, "") for ids in known.values())
    for mark, points in every:
        id_ = known.get(mark.student, {}).get(kind, "")
        if id_ and count[id_] > 1:
            same.append(mark)
        elif id_ and (not times or mark.student in times):
            time = [Verbatim(times[mark.student])] if times else []
            rows.append([Verbatim(id_), scaled(points, task, most), *time])
        elif mark not in locked:
            lost.append(mark)
    book.leaves_out(file, f"shares their {heading}", same)
    if not rows:
        return None
    if not most:
        book.remark(
            f"{file} is out of {task.points:g} points: where the grade item has another maximum, "
            "import the grading worksheet, or give it as a --roster"
        )
    book.leaves_out(file, f"has no {heading} in the roster", lost)
    header: list[Cell] = [heading, Verbatim(column or book.titles.get(task.slug, task.title))]
    return csv_text([[*header, *([DOWNLOADED] if times else [])], *rows])


def _times(book: Book, marks: Sequence[Mark], sheets: Sequence[Sheet]) -> dict[str, str]:
    """Return when the grades of each student were downloaded; none if no sheet says it."""
    for sheet_ in sheets:
        heading = DOWNLOADED.casefold()
        if heading in sheet_.small:
            times = {m.student: sheet_.cell(book.row_of(sheet_, m), heading) for m in marks}
            return {student: time for student, time in times.items() if time}
    return {}


def worksheet_csv(book: Book, task: Task) -> str | None:
    """Return one exercise's grading worksheet; None if no submission came from Moodle."""
    theirs = [each for each in book.marks(task) if each[0].handed.system == "moodle"]
    file, worksheet = f"moodle/{task.slug}-worksheet.csv", _worksheet(book, task)
    if not theirs or _is_scale(book, file, _maximum(worksheet)):
        return None
    if worksheet is not None:
        return _filled_in(book, task, worksheet, theirs)
    plain: list[list[Cell]] = [
        [Verbatim(f"Participant {mark.handed.id}"), mark.name, points, task.points, Verbatim("-")]
        for mark, points in theirs
    ]
    return csv_text([list(map(Verbatim, WORKSHEET)), *plain])


def _filled_in(
    book: Book, task: Task, worksheet: _Worksheet, theirs: Sequence[tuple[Mark, float]]
) -> str:
    """Return Moodle's own worksheet with the new grades, without its columns of feedback."""
    header, file = worksheet.sheet.small, f"moodle/{task.slug}-worksheet.csv"
    end = header.index(GRADED_AT) + 1 if GRADED_AT in header else len(header)
    made: list[list[Cell]] = [list(map(Verbatim, worksheet.sheet.header[:end]))]
    locked, lost = [], []
    for mark, points in theirs:
        row = worksheet.rows.get(mark.handed.id)
        if row is None:
            lost.append(mark)
        elif worksheet.is_locked(mark):
            locked.append(mark)
        else:
            cells: list[Cell] = [
                value if heading == "full name" else Verbatim(value)
                for heading, value in zip(header[:end], row[:end], strict=True)
            ]
            most = worksheet.cell(mark.handed.id, MOST)
            cells[header.index(GRADE)] = scaled(points, task, most)
            made.append(cells)
    book.leaves_out(file, f"is not in {worksheet.sheet.file.name}", lost)
    book.leaves_out(file, LOCKED, locked)
    return csv_text(made)


def feedback(target: BinaryIO, marks: Sequence[Mark], task: Task, pages: Path) -> None:
    """Write one exercise's feedback pages as Moodle takes them back."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for mark in marks:
            page = pages / mark.student / f"{task.slug}.html"
            if not page.is_file():
                continue
            name = student_id(mark.handed.name).replace("_", " ")
            folder = f"{name}_{mark.handed.id}_assignfeedback_file"
            info = zipfile.ZipInfo(f"{folder}/{task.slug}.html", EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, page.read_bytes())


PLATFORM = Platform(
    "Moodle",
    read,
    sheet,
    gradebook,
    feedback,
    folder="moodle",
    what="Moodle: grade import, worksheets, feedback files",
)
