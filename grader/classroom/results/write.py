"""Write all results of a graded class."""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import groupby
from pathlib import Path

from grader.classroom.marks import checks_of, is_graded, tasks_of
from grader.classroom.results.check_pages import CHECKS, check_pages
from grader.classroom.results.class_page import class_page
from grader.classroom.results.feedback import index_page, lost_page, write_page
from grader.classroom.results.files import replacing, write_text
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.page import render
from grader.classroom.results.published import write_published
from grader.classroom.results.scores import book_of, scores_csv
from grader.classroom.row import StoredResult, as_graded
from grader.errors import is_disk_full
from grader.lms import PLATFORMS
from grader.lms.book import Book, Task
from grader.lms.clean import one_line
from grader.lms.nbgrader import write_into

CLASS_PAGE = "class.html"
BOM = "\ufeff"  # without it Excel doesn't read the file as UTF-8
MANY = 20  # students; for fewer, starting more processes does not pay
OURS = {"scores.csv": "every grading, for a spreadsheet", "intake.csv": "what became of each file"}


@dataclass(frozen=True)
class Written:
    """What was written, and what could not be made."""

    files: list[Path] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)  # a line each

    @contextlib.contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Note that a part is missing if the block fails; a full disk is no part's fault."""
        try:
            yield
        except Exception as error:
            if is_disk_full(error):
                raise
            self.missing.append(f"{name}: {type(error).__name__}: {one_line(error, 200)}")


def write_results(
    results: Sequence[StoredResult], out: Path, options: ResultOptions | None = None
) -> Written:
    """Write the class report, feedback and gradebooks into `out`.

    The same results give the same files. Each file is replaced atomically, so nobody reads half of
    one. The files of a platform, the pages of a student and the class report fail alone; the report
    names what is missing.

    Raises OSError: a full disk, or a folder that can't be written.
    """
    options, done = options or ResultOptions(), Written()
    known, tasks = _in_order(results)
    by_slug = {task.slug: task for task in tasks}
    book = book_of(known, tasks, options)
    _write_tables(known, tasks, out, options, done)
    _write_gradebooks(book, tasks, out, options, done)
    for each in _made(known, by_slug, out, options):
        done.files.extend(each.files)
        done.missing.extend(each.missing)
    _write_feedback_zips(book, tasks, out, options, done)
    with done.part("the published feedback"):
        shown = options.published or ()
        done.files.extend(write_published(known, by_slug, out, shown, options.title))
    shutil.rmtree(out / CHECKS, ignore_errors=True)
    with done.part(CHECKS):
        for name, text in check_pages(known, tasks, options):
            done.files.append(write_text(out / name, text))
    options = replace(options, notes=[*options.notes, *book.remarks], files=_there(done.files, out))
    _write_class_page(known, tasks, out, options, done)
    return done


def write_pages(results: Sequence[StoredResult], out: Path, options: ResultOptions) -> list[Path]:
    """Write only the class report and the scores into `out`."""
    (known, tasks), done = _in_order(results), Written()
    _write_tables(known, tasks, out, options, done)
    _write_class_page(known, tasks, out, options, done)
    return done.files


def _in_order(results: Sequence[StoredResult]) -> tuple[list[StoredResult], list[Task]]:
    """Return what students handed in, with the exercises, in their orders."""
    known = [result for result in results if not result.canary]
    tasks = tasks_of(known)
    order = {task.slug: index for index, task in enumerate(tasks)}
    return sorted(known, key=lambda each: (each.student, order[each.exercise])), tasks


def _write_class_page(
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    out: Path,
    options: ResultOptions,
    done: Written,
) -> None:
    """Write class.html; if it can't be made, a bare page with what is missing."""
    text = ""
    with done.part(CLASS_PAGE):
        text = class_page(results, tasks, options, done.missing)
    text = text or render("bare.html", "class report", missing=done.missing)
    done.files.append(write_text(out / CLASS_PAGE, text))


# --- gradebooks ----------------------------------------------------------------------------------


def _write_tables(
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    out: Path,
    options: ResultOptions,
    done: Written,
) -> None:
    text = scores_csv(results, tasks, options.students)
    done.files.append(write_text(out / "scores.csv", BOM + text))
    (out / "intake.csv").unlink(missing_ok=True)
    if options.account.lines:
        done.files.append(write_text(out / "intake.csv", BOM + options.account.csv()))


def _write_gradebooks(
    book: Book, tasks: Sequence[Task], out: Path, options: ResultOptions, done: Written
) -> None:
    """Write all files for gradebooks; older ones would be taken for this run's, and are removed."""
    for platform in PLATFORMS:
        if platform.what:
            shutil.rmtree(out / platform.folder, ignore_errors=True)
        with done.part(f"{platform.name}'s files"):
            for name, content in platform.gradebook(book, tasks).items():
                done.files.append(write_text(out / name, content))
    if options.nbgrader is not None:
        with done.part(f"nbgrader's gradebook {options.nbgrader}"):
            write_into(options.nbgrader, book, tasks)


def _write_feedback_zips(
    book: Book, tasks: Sequence[Task], out: Path, options: ResultOptions, done: Written
) -> None:
    """Write the feedback pages as platforms take them back: all, or those published."""
    for platform in PLATFORMS:
        for task in tasks if platform.feedback is not None else ():
            marks = [
                mark
                for mark, _ in book.marks(task)
                if mark.handed.system == platform.folder
                and (options.published is None or (mark.student, task.slug) in options.published)
            ]
            if marks and platform.feedback is not None:
                path = out / platform.folder / f"{task.slug}-feedback.zip"
                with done.part(path.name):
                    with replacing(path) as file:
                        platform.feedback(file, marks, task, out / "feedback")
                    done.files.append(path)


def _there(written: Iterable[Path], out: Path) -> list[tuple[str, str, tuple[str, ...]]]:
    """Return what was written for the report's last lines; of folders, the files in them."""
    names = sorted(path.relative_to(out).as_posix() for path in written)
    every = OURS | {each.folder: each.what for each in PLATFORMS if each.what}
    found = []
    for name, what in every.items():
        inside = tuple(each for each in names if each == name or each.rpartition("/")[0] == name)
        if inside:
            found.append((name if inside == (name,) else f"{name}/", what, inside))
    return found


# --- students' pages -----------------------------------------------------------------------------


def _made(
    results: Sequence[StoredResult], tasks: Mapping[str, Task], out: Path, options: ResultOptions
) -> Iterator[Written]:
    """Make the pages, in several processes if there are many."""
    students = [list(mine) for _, mine in groupby(results, key=lambda result: result.student)]
    # what a process needs to know
    about = (tasks, out, options.hidden, options.replays_in, options.title)
    make = functools.partial(_write_student, *about)
    if options.workers == 1 or len(students) < MANY:
        yield from map(make, students)
        return
    # spawned: this process may have threads, of Dask or the progress bar
    with ProcessPoolExecutor(options.workers, multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(make, students)


def _write_student(
    tasks: Mapping[str, Task],
    out: Path,
    hidden: frozenset[str],
    replays_in: str,
    title: str,
    results: Sequence[StoredResult],
) -> Written:
    """Write a student's pages; if one can't be made, one that says so takes the place of all."""
    student, done = results[0].student, Written()
    folder = out / "feedback" / student
    with done.part(f"the feedback of {one_line(student)}"):
        index = index_page(student, results, tasks, title)
        done.files.append(write_text(folder / "index.html", index))
        for result in results:
            task = tasks[result.exercise]
            page = folder / f"{task.slug}.html"
            if not is_graded(result):
                page.unlink(missing_ok=True)  # from an earlier run; it no longer counts
                continue
            # an absolute path stays itself
            bags = None if result.recordings is None else out / result.recordings
            done.files.append(write_page(page, result, task, hidden, bags))
            failed = any(check.get("outcome") == "fail" for check in checks_of(as_graded(result)))
            if replays_in != "feedback" and bags is not None and failed:
                mine = out / replays_in / folder.name / page.name
                done.files.append(write_page(mine, result, task, frozenset(), bags))
        return done
    for page in folder.glob("*.html"):
        page.unlink()
    return Written([write_text(folder / "index.html", lost_page(student))], done.missing)
