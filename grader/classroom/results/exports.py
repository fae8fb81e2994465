"""The files for gradebooks: which ones a class needs depends on where its work came from."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable, Collection, Sequence
from functools import partial
from pathlib import Path

from grader.classroom.results.canvas import canvas_csv
from grader.classroom.results.clean import cell, folder_name
from grader.classroom.results.files import replacing, write_text
from grader.classroom.results.gradebook import Book
from grader.classroom.results.gradebooks import nbgrader_csv, scores_csv, write_into_nbgrader
from grader.classroom.results.gradescope import results_json
from grader.classroom.results.gradescope_upload import by_submission, write_autograder
from grader.classroom.results.junit import junit_xml
from grader.classroom.results.marks import Task
from grader.classroom.results.missing import Parts
from grader.classroom.results.moodle import grades_csv, worksheet_csv, write_feedback_zip
from grader.classroom.results.options import Linked, ResultOptions
from grader.classroom.row import StoredResult
from grader.report.page import json_text

BOM = "\ufeff"  # without it Excel doesn't read the file as UTF-8
WHAT = {
    "scores.csv": "every grading, for a spreadsheet",
    "intake.csv": "what became of each file",
    "canvas": "Canvas gradebook, a file per exercise",
    "moodle": "Moodle: grade import, worksheets, feedback files",
    "gradescope": "Gradescope: an autograder that hands out the results, and each results.json",
    "nbgrader.csv": "as nbgrader exports",
    "junit.xml": "JUnit XML",
}
OURS = ("canvas", "moodle")  # folders
ANYWHERE = {"folder", "csv"}  # systems that say nothing of the gradebook

Make = Callable[[], str | None]


def write_exports(
    book: Book, tasks: Sequence[Task], out: Path, options: ResultOptions, parts: Parts
) -> list[Path]:
    """Write all but what needs the feedback pages; older files are removed first."""
    systems = book.systems()
    for name in OURS:
        shutil.rmtree(out / name, ignore_errors=True)
    texts: dict[str, Make] = {
        "scores.csv": lambda: BOM + scores_csv(book.results, tasks, book.students),
        "junit.xml": lambda: junit_xml(book.results, tasks),
        "intake.csv": lambda: BOM + options.account.csv(cell) if options.account.lines else None,
        "nbgrader.csv": lambda: nbgrader_csv(book, tasks) if "nbgrader" in systems else None,
    }
    for task in tasks:
        if systems <= ANYWHERE or "canvas" in systems:
            texts[f"canvas/{task.folder}.csv"] = partial(canvas_csv, book, task)
        if systems <= ANYWHERE or systems & {"moodle", "worksheet"}:
            texts[f"moodle/{task.folder}.csv"] = partial(grades_csv, book, task)
            texts[f"moodle/{task.folder}-worksheet.csv"] = partial(worksheet_csv, book, task)
    written = []
    for name, make in texts.items():
        (out / name).unlink(missing_ok=True)  # an older one would be taken for this run's
        with parts.part(name):
            text = make()
            if text is not None:
                written.append(write_text(out / name, text))
    autograder = out / "gradescope" / "autograder.zip"
    autograder.unlink(missing_ok=True)
    if "gradescope" in systems:
        with parts.part(autograder.relative_to(out).as_posix()):
            final = by_submission(book.results, tasks, book.students, options.hidden)
            with replacing(autograder) as file:
                write_autograder(file, final)
            written.append(autograder)
    if options.nbgrader is not None:
        with parts.part(f"nbgrader's gradebook {options.nbgrader}"):
            write_into_nbgrader(options.nbgrader, book, tasks)
    return written


def write_feedback_zips(
    book: Book,
    tasks: Sequence[Task],
    out: Path,
    parts: Parts,
    published: Collection[tuple[str, str]] | None = None,
) -> list[Path]:
    """Write the feedback pages for Moodle, once they are made: all, or those published."""
    written = []
    for task in tasks:
        path = out / "moodle" / f"{task.folder}-feedback.zip"
        marks = [mark for mark in book.marks(task) if mark.handed(task.slug).system == "moodle"]
        if published is not None:
            marks = [mark for mark in marks if (mark.student, task.slug) in published]
        if not marks:
            continue
        with parts.part(path.relative_to(out).as_posix()):
            with replacing(path) as file:
                write_feedback_zip(file, marks, task, out / "feedback")
            written.append(path)
    return written


def write_for_gradescope(
    book: Book,
    student: str,
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    out: Path,
    options: ResultOptions,
    parts: Parts,
) -> list[Path]:
    """Write one student's results.json where the class may be Gradescope's; an older one goes."""
    path = out / "gradescope" / folder_name(student) / "results.json"
    systems = book.systems()
    if systems <= ANYWHERE or "gradescope" in systems:
        with parts.part(f"the Gradescope results of {student}"):
            final = results_json(results, tasks, options.hidden)
            if final is not None:
                return [write_text(path, json_text(final))]
    path.unlink(missing_ok=True)
    for folder in (path.parent, path.parent.parent):
        with contextlib.suppress(OSError):  # it is missing, or holds other files
            folder.rmdir()
    return []


def there(written: Sequence[Path], out: Path) -> list[Linked]:
    """Return what was written for the report's last lines; of folders, the files in them."""
    names = sorted(path.relative_to(out).as_posix() for path in written)
    found = []
    for name, what in WHAT.items():
        inside = [each for each in names if each.startswith(f"{name}/")]
        if name in names:
            found.append(Linked(name, what, (name,)))
        elif inside:
            found.append(Linked(f"{name}/", what, tuple(inside)))
    return found
