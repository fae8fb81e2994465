"""Write all results of a graded class."""

import contextlib
import functools
import shutil
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import groupby, product
from pathlib import Path

from grader.classroom.amendments.marks import as_shown, checks_of, is_graded, task_of, tasks_of
from grader.classroom.results.class_page import class_page
from grader.classroom.results.feedback import index_page, lost_page, write_page
from grader.classroom.results.files import replacing, write_text
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.page import render
from grader.classroom.results.scores import book_of, scores_csv
from grader.classroom.row import StoredResult, as_graded
from grader.errors import GraderError, is_disk_full
from grader.lms.book import Book, Task
from grader.lms.clean import one_line
from grader.lms.platforms import PLATFORMS
from grader.processes import own_processes

CLASS_PAGE = "class.html"
PUBLISHED = "published"  # the folder
GONE = ("checks", "likeness")  # folders of version 1.0.0: nothing renews them
BOM = "\ufeff"  # without it Excel doesn't read the file as UTF-8
EVERY = 10  # students, of whose pages it is said how many are written
MANY = 20  # students; for fewer, starting more processes does not pay
ENDED = (
    "a process that makes feedback pages was ended from outside (is there memory enough?); what is "
    "graded and logged is stored, and `course marks write {out}` writes the rest"
)
Results = Sequence[StoredResult]
Tasks = Sequence[Task]  # in the order of the lesson


@dataclass(frozen=True)
class Written:
    """What was written into a folder, and what could not be made."""

    out: Path
    files: list[Path] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)  # a line each

    def text(self, name: str, text: str) -> None:
        self.files.append(write_text(self.out / name, text))

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
    results: Results, out: Path, options: ResultOptions | None = None,
    same: Collection[str] = (), say: Callable[[str], object] = str,
) -> Written:  # fmt: skip
    """Write the class report, feedback and gradebooks into `out`.

    The same results give the same files. Each file is replaced atomically, so nobody reads half of
    one. The files of a platform, the pages of a student and the class report fail alone; the report
    names what is missing. The pages of students who are the `same` as the last time stay. `say` is
    told how far it is.

    Raises OSError: a full disk, or a folder that can't be written.
    """
    options, done = options or ResultOptions(), Written(out)
    tasks = tasks_of(results)
    known = sorted(results, key=lambda each: (each.student, task_of(each.exercise).number))
    book = book_of(known, options)
    done.text("scores.csv", BOM + scores_csv(known, options.students))
    (out / "intake.csv").unlink(missing_ok=True)
    if options.account.lines:
        done.text("intake.csv", BOM + options.account.csv())
    _write_gradebooks(book, tasks, options, done)
    new = [result for result in known if result.student not in same]
    count = len({result.student for result in new})
    for number, each in enumerate(_made(new, options, out), start=1):
        if number % EVERY == 0:
            say(f"the pages of {number} of {count} students are written")
        done.files.extend(each.files)
        done.missing.extend(each.missing)
    _write_feedback_zips(book, tasks, options, done)
    with done.part("the published feedback"):
        _write_published(known, options, done, same)
    for gone in GONE:
        shutil.rmtree(out / gone, ignore_errors=True)
    tables = sorted(
        path.relative_to(out).as_posix() for path in done.files if path.suffix in (".csv", ".zip")
    )
    options = replace(options, notes=[*options.notes, *book.remarks], files=tables)
    page = ""
    with done.part(CLASS_PAGE):
        page = class_page(known, tasks, options, done.missing)
    done.text(CLASS_PAGE, page or render("bare.html", "class report", missing=done.missing))
    return done


# --- gradebooks ----------------------------------------------------------------------------------


def _write_gradebooks(book: Book, tasks: Tasks, options: ResultOptions, done: Written) -> None:
    """Write all files for gradebooks; older ones would be taken for this run's, and are removed."""
    for platform in PLATFORMS:
        if platform.folder:
            shutil.rmtree(done.out / platform.folder, ignore_errors=True)
        with done.part(f"{platform.name}'s files"):
            for name, text in platform.gradebook(book, tasks).items():
                done.text(name, text)


def _write_feedback_zips(book: Book, tasks: Tasks, options: ResultOptions, done: Written) -> None:
    """Write the feedback pages as platforms take them back: all, or those published."""
    shown = options.published
    for platform, task in product(PLATFORMS, tasks):
        marks = [
            mark
            for mark, _ in book.marks(task)
            if mark.handed.system == platform.word
            and (shown is None or (mark.student, task.slug) in shown)
        ]
        if marks and platform.feedback is not None:
            path = done.out / platform.folder / f"{task.slug}-feedback.zip"
            with done.part(path.name):
                with replacing(path) as file:
                    platform.feedback(file, marks, task, done.out / "feedback")
                done.files.append(path)


# --- students' pages -----------------------------------------------------------------------------


def _made(results: Results, options: ResultOptions, out: Path) -> Iterator[Written]:
    students = [list(mine) for _, mine in groupby(results, key=lambda result: result.student)]
    # what a process needs to know
    about = ResultOptions(options.hide, options.title)
    make = functools.partial(_write_student, about, out)
    if options.workers == 1 or len(students) < MANY:
        yield from map(make, students)
        return
    # spawned: this process may have threads, of Dask or the progress bar
    try:
        with ProcessPoolExecutor(options.workers, own_processes()) as pool:
            yield from pool.map(make, students)
    except BrokenExecutor:
        raise GraderError(ENDED.format(out=out)) from None


def _write_student(options: ResultOptions, out: Path, results: Results) -> Written:
    """Write a student's pages; if one can't be made, one that says so takes the place of all."""
    student, done = results[0].student, Written(out)
    folder = out / "feedback" / student
    with done.part(f"the feedback of {one_line(student)}"):
        shown = [as_shown(result, options.hidden) for result in results]
        index = index_page(student, shown, options.title)
        done.text(f"feedback/{student}/index.html", index)
        for result in results:
            page = folder / f"{result.exercise}.html"
            if not is_graded(result):
                page.unlink(missing_ok=True)  # from an earlier run; it no longer counts
                continue
            # an absolute path stays itself
            bags = None if result.recordings is None else out / result.recordings
            done.files.append(write_page(page, result, options.hidden, bags))
            failed = any(check.get("outcome") == "fail" for check in checks_of(as_graded(result)))
            if options.replays_in != "feedback" and bags is not None and failed:
                mine = out / options.replays_in / folder.name / page.name
                done.files.append(write_page(mine, result, frozenset(), bags))
        return done
    for page in folder.glob("*.html"):
        page.unlink()
    return Written(out, [write_text(folder / "index.html", lost_page(student))], done.missing)


def _write_published(
    results: Results, options: ResultOptions, done: Written, same: Collection[str]
) -> None:
    """Copy what students may see: the pages that are published, and no other.

    Students may read them meanwhile, so a page that stays is never away.
    """
    folder, shown = done.out / PUBLISHED, options.published or ()
    there = set(folder.glob("*/*.html"))
    stay: set[Path] = set()
    theirs = [each for each in results if each.key in shown]
    for student, each in groupby(theirs, key=lambda result: result.student):
        mine = list(each)
        pages = [f"{one.exercise}.html" for one in mine if is_graded(one)]
        pages = [each for each in pages if (done.out / "feedback" / student / each).is_file()]
        wanted = {folder / student / each for each in ("index.html", *pages)}
        stay |= wanted
        if student in same and wanted == set((folder / student).glob("*.html")):
            continue
        shown_now = [as_shown(result, options.hidden) for result in mine]
        index = index_page(student, shown_now, options.title)
        done.text(f"{PUBLISHED}/{student}/index.html", index)
        for name in pages:
            text = (done.out / "feedback" / student / name).read_text("utf-8")
            done.text(f"{PUBLISHED}/{student}/{name}", text)
    for page in there - stay:
        page.unlink()
    for emptied in (*folder.glob("*/"), folder):
        with contextlib.suppress(OSError):  # it holds pages, or somebody's own files
            emptied.rmdir()
