"""Moodle: a folder per student, grading worksheet, feedback files.

Sources, in moodle/moodle:

- mod/assign/classes/downloader.php (`get_student_prefix`, `load_submissionplugin_filelist`):
  `FULLNAME_ID_assignsubmission_file`, with `_` in the name turned into a space, then the student's
  folders and files, or `_FILENAME` if "Download submissions in folders" is off; up to Moodle 4.0 a
  folder ended in `_`. The id is that of the participant in this one assignment, as in its grading
  worksheet. Group submissions are `GROUP_ID_assignsubmission_file`.
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
from collections.abc import Mapping, Sequence
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
KIND = "worksheet"  # of a roster's sheet
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
        return KIND
    named = {"first name", "last name", "surname", "full name", "name"} & set(header)
    exported = DOWNLOADED.casefold() in header or ("id number" in header and named)
    return "moodle" if exported else ""


def gradebook(book: Book, tasks: Sequence[Task]) -> Files:
    """Return a grading worksheet per exercise."""
    if not book.may_be("moodle", KIND):
        return {}
    made = {_file(task): worksheet_csv(book, task, alone=len(tasks) == 1) for task in tasks}
    return {name: text for name, text in made.items() if text}


def _file(task: Task) -> str:
    return f"moodle/{task.slug}-worksheet.csv"


def worksheet_csv(book: Book, task: Task, *, alone: bool = True) -> str | None:
    """Return one exercise's grading worksheet; None if nobody in it can be identified.

    Filled in is the roster's worksheet with this assignment's participants; of a class with one
    exercise `alone` its only worksheet, wherever the work came from.
    """
    every, sheets = book.marks(task), [each for each in book.sheets(KIND) if each.rows]
    here = [(mark, points) for mark, points in every if mark.handed.system == "moodle"]
    ids = {mark.handed.id for mark, _ in here}
    found = [each for each in sheets if ids & _by_participant(each).keys()]
    if not here and alone and len(sheets) == 1:
        found = sheets
    if found:
        return None if _is_scale(book, task, found[0]) else _filled_in(book, task, found[0], every)
    plain: list[list[Cell]] = [
        [Verbatim(f"Participant {mark.handed.id}"), mark.name, points, task.points, Verbatim("-")]
        for mark, points in here
    ]
    return csv_text([list(map(Verbatim, WORKSHEET)), *plain]) if plain else None


def _by_participant(worksheet: Sheet) -> Mapping[str, Sequence[str]]:
    rows = ((worksheet.cell(row, IDENTIFIER).rpartition(" ")[2], row) for row in worksheet.rows)
    return {digits: row for digits, row in rows if digits.isdecimal()}


def _is_scale(book: Book, task: Task, worksheet: Sheet) -> bool:
    """Return whether an assignment has no points: minus a scale's number is there, or zero."""
    most = worksheet.cell(worksheet.rows[0], MOST)
    try:
        points = not most or float(most.replace(",", ".")) > 0
    except ValueError:
        points = False
    if not points:
        book.remark(
            f"{_file(task)} is not written: the assignment's maximum grade is "
            f"{one_line(most, 60)!r}, so Moodle grades it on a scale or not at all; choose points "
            "in its settings"
        )
    return not points


def _filled_in(
    book: Book, task: Task, worksheet: Sheet, every: Sequence[tuple[Mark, float]]
) -> str | None:
    """Return Moodle's own worksheet with the new grades, without its columns of feedback."""
    header, rows = worksheet.small, _by_participant(worksheet)
    end = header.index(GRADED_AT) + 1 if GRADED_AT in header else len(header)
    made: list[list[Cell]] = [list(map(Verbatim, worksheet.header[:end]))]
    locked, lost = [], []
    for mark, points in every:
        is_moodles = mark.handed.system == "moodle"
        row = rows.get(mark.handed.id) if is_moodles else book.row_of(worksheet, mark)
        if row is None:
            lost.append(mark)
        elif worksheet.cell(row, CHANGEABLE).casefold() == "no":
            locked.append(mark)
        else:
            cells: list[Cell] = [
                value if heading == "full name" else Verbatim(value)
                for heading, value in zip(header[:end], row[:end], strict=True)
            ]
            cells[header.index(GRADE)] = scaled(points, task, worksheet.cell(row, MOST))
            made.append(cells)
    book.leaves_out(_file(task), f"is not in {worksheet.file.name}", lost)
    book.leaves_out(_file(task), LOCKED, locked)
    return csv_text(made) if len(made) > 1 else None


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
    what="Moodle: grading worksheets, feedback files",
)
