"""Write all results of a graded class."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

from grader.classroom.results import sections
from grader.classroom.results.alike import Alikes
from grader.classroom.results.check_pages import write_check_pages
from grader.classroom.results.class_page import bare_page, class_page
from grader.classroom.results.clean import folder_name
from grader.classroom.results.exercise_section import judged_ones
from grader.classroom.results.exports import (
    BOM,
    there,
    write_exports,
    write_feedback_zips,
    write_for_gradescope,
)
from grader.classroom.results.feedback import (
    exercise_page,
    index_page,
    lost_page,
    wants_bags,
)
from grader.classroom.results.files import write_text
from grader.classroom.results.gradebook import Book
from grader.classroom.results.gradebooks import scores_csv
from grader.classroom.results.gradescope import results_json
from grader.classroom.results.items import item_analysis
from grader.classroom.results.junit import junit_xml
from grader.classroom.results.marks import Task, checks_of, is_graded, tasks_of
from grader.classroom.results.missing import Missing, Parts
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.published import write_published
from grader.classroom.row import HELD, StoredResult, as_graded
from grader.report.page import page_html

CLASS_PAGE = "class.html"
PAGES = ".pages.json"  # hashes of what each feedback page was made from
ALIKE = ".alike.json"
REPLAYS = "#replays"  # behind a page's name in PAGES
MANY = 20  # pages; for fewer, starting more processes does not pay


@dataclass(frozen=True)
class Written:
    """What was written, and what could not be made."""

    files: list[Path]
    missing: list[Missing]


def write_results(
    results: Sequence[StoredResult], out: Path, options: ResultOptions | None = None
) -> Written:
    """Write the class report, feedback, gradebooks and JUnit XML into `out`.

    The same results give the same files. Each file is replaced atomically, so nobody reads half of
    one. A file or a section that can't be made costs only itself: class.html names it.

    Raises
    ------
    OSError
        A full disk, or a folder that can't be written.
    """
    options = replace(options or ResultOptions(), alikes=Alikes(out / ALIKE))
    parts = Parts()
    known, tasks = _in_order(results, parts)
    book = Book(known, options.students, options.roster, options.columns)
    written = write_exports(book, tasks, out, options, parts)
    options = replace(options, notes=[*options.notes, *book.remarks], files=there(written, out))
    written.append(_write_class_page(known, tasks, out, options, parts))
    written += _write_section_pages(known, tasks, out, options, parts)
    judged = {task.slug: judged_ones([r for r in known if r.exercise == task.slug])
              for task in tasks}  # fmt: skip
    written += write_check_pages(judged, tasks, out, options.replays_in, options.title, parts)
    pages = _Pages(out / PAGES)
    due: list[_Page] = []
    for student, each in groupby(known, key=lambda result: result.student):
        mine = list(each)
        written += _write_student(student, mine, tasks, out, options, pages, due, parts)
        written += write_for_gradescope(book, student, mine, tasks, out, options, parts)
    for page, lost in _make(due, options.workers):
        parts.missing += lost
        pages.forget(page)
    written += write_feedback_zips(book, tasks, out, parts, options.published)
    written += write_published(known, tasks, out, options.published or (), options.title, parts)
    with parts.part("the list of submissions that are nearly the same"):
        options.alikes.save()
    with parts.part("the list of pages that are up to date"):
        pages.save()
    if parts.missing:
        _write_class_page(known, tasks, out, options, parts)  # again: it names what is missing
    return Written(written, parts.missing)


def write_pages(results: Sequence[StoredResult], out: Path, options: ResultOptions) -> list[Path]:
    """Write only the class report and the scores into `out`."""
    parts = Parts()
    known, tasks = _in_order(results, parts)
    scores = write_text(out / "scores.csv", BOM + scores_csv(known, tasks, options.students))
    return [_write_class_page(known, tasks, out, options, parts), scores]


def _in_order(
    results: Sequence[StoredResult], parts: Parts
) -> tuple[list[StoredResult], list[Task]]:
    """Return what students handed in, with the exercises, in their orders."""
    known = [_sound(result, parts) for result in results if not result.canary]
    tasks = [replace(task, folder=folder_name(task.slug)) for task in tasks_of(known)]
    order = {task.slug: index for index, task in enumerate(tasks)}
    known.sort(key=lambda result: (result.student, order[result.exercise]))
    return known, tasks


def _sound(result: StoredResult, parts: Parts) -> StoredResult:
    """Return the result if its figures can be read; held, without them, if not."""
    name = f"the grading of {result.student} in {result.exercise}"
    with parts.part(name):
        task = Task(result.exercise, 0, "", 1.0)
        scores_csv([result], [task])
        junit_xml([result], [task])
        item_analysis([result])
        results_json([result], [task], frozenset())
        return result
    problem = f"the stored grading can't be read ({parts.missing[-1].why})"
    return replace(result, state=HELD, grading=None, problem=problem)


def _write_class_page(
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    out: Path,
    options: ResultOptions,
    parts: Parts,
) -> Path:
    """Write class.html; if it can't be made as a whole, a bare page with what is missing."""
    own = Parts()
    text = own.made(
        CLASS_PAGE,
        lambda: class_page(results, tasks, options, parts.missing, own),
        lambda _: bare_page([*parts.missing, *own.missing]),
    )
    parts.missing += [each for each in own.missing if each not in parts.missing]
    return write_text(out / CLASS_PAGE, text)


def _write_section_pages(
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    out: Path,
    options: ResultOptions,
    parts: Parts,
) -> list[Path]:
    """Write the report of each section of the roster."""
    sections.remove_old(out)
    written = []
    for title, mine in sections.sections_of(results, options).items():
        with parts.part(f"the report of section {title}"):
            theirs = [task for task in tasks if any(r.exercise == task.slug for r in mine)]
            text = class_page(mine, theirs, sections.of_section(options, title), (), parts)
            written.append(write_text(out / sections.page_of(title), text))
    return written


@dataclass(frozen=True)
class _Page:
    """A feedback page to make."""

    path: Path
    result: StoredResult
    task: Task
    hidden: frozenset[str]
    bags: Path | None
    keeps_replays: bool = False  # those of the page that is there are right

    def made_of(self) -> tuple[object, ...]:
        """Return all that the page depends on."""
        one = self.result
        changed = () if one.amended is None else (one.amended.points, one.amended.steps)
        told = (one.student, self.task.title, one.grading, one.file_names, one.finished)
        return (
            *told,
            *changed,
            sorted(self.hidden),
            None if self.bags is None else _state(self.bags),
        )

    def replays_made_of(self) -> tuple[object, ...]:
        """Return all that the page's replays depend on, but for the moments in them."""
        return (sorted(self.hidden), None if self.bags is None else _state(self.bags))

    @property
    def name(self) -> str:
        return f"the feedback page of {self.result.student} in {self.task.heading}"

    def make(self) -> list[Missing]:
        """Write the page, without its replays if they can't be made; return what is missing."""
        parts = Parts()
        with parts.part(f"the replays of {self.name.removeprefix('the ')}"):
            before = self.path if self.keeps_replays else None
            text = exercise_page(self.result, self.task, self.hidden, self.bags, before)
            write_text(self.path, text)
            return []
        with parts.part(self.name):
            write_text(self.path, exercise_page(self.result, self.task, self.hidden, None))
            return parts.missing[:1]
        return self.give_up(parts.missing[-1])

    def give_up(self, lost: Missing) -> list[Missing]:
        """Put a page that says so in the place of one that can't be made, or of an older one."""
        write_text(self.path, lost_page(self.result, self.task))
        return [lost]


def _make(pages: Sequence[_Page], workers: int) -> Iterator[tuple[Path, list[Missing]]]:
    """Make the pages, in several processes if there are many; return those that miss something."""
    left = list(pages)
    if workers > 1 and len(pages) >= MANY:
        yield from _made_by_processes(left, workers)
    for page in left:
        if lost := page.make():
            yield page.path, lost


def _made_by_processes(left: list[_Page], workers: int) -> Iterator[tuple[Path, list[Missing]]]:
    """Make the pages of the list, and leave none in it; one may cost its process its life."""
    suspects: list[_Page] = []
    # spawned: this process may have threads, of Dask or the progress bar
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        tasks = [(page, pool.submit(page.make)) for page in left]
        left.clear()
        for page, task in tasks:
            try:
                lost = task.result()
            except BrokenExecutor:
                suspects.append(page)
                continue
            if lost:
                yield page.path, lost
    for page in suspects:  # alone, so that the others come through
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
            try:
                lost = pool.submit(page.make).result()
            except BrokenExecutor:
                lost = page.give_up(Missing(page.name, "its process died while making it"))
        if lost:
            yield page.path, lost


class _Pages:
    """Remembers what each page was made from: a replay takes 0.5 s, and a class has thousands."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._before = self._load()
        self._now: dict[str, str] = {}
        self._look = page_html({})  # a new player makes new pages

    def is_fresh(self, page: Path, *made_of: object) -> bool:
        """Tell whether the page exists and was made from the same; remember that for `save`."""
        name = page.relative_to(self._file.parent).as_posix()
        text = json.dumps([self._look, *made_of], sort_keys=True, default=str)
        self._now[name] = hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()
        return page.is_file() and self._before.get(name) == self._now[name]

    def keeps_replays(self, page: Path, *made_of: object) -> bool:
        """Tell whether the page's replays were made from the same; remember that for `save`."""
        name = f"{page.relative_to(self._file.parent).as_posix()}{REPLAYS}"
        text = json.dumps([self._look, *made_of], default=str)
        self._now[name] = hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()
        return page.is_file() and self._before.get(name) == self._now[name]

    def forget(self, page: Path) -> None:
        """Have the page made again in the next run."""
        name = page.relative_to(self._file.parent).as_posix()
        for each in (name, f"{name}{REPLAYS}"):
            self._now.pop(each, None)

    def save(self) -> None:
        """Store the hashes, after the pages are written."""
        write_text(self._file, json.dumps(self._now, indent=1, sort_keys=True) + "\n")

    def _load(self) -> dict[str, str]:
        try:
            found = json.loads(self._file.read_text("utf-8"))
        except (OSError, ValueError):
            return {}
        return found if isinstance(found, dict) else {}


def _write_student(
    student: str,
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    out: Path,
    options: ResultOptions,
    pages: _Pages,
    due: list[_Page],
    parts: Parts,
) -> list[Path]:
    by_slug = {task.slug: task for task in tasks}
    folder = out / "feedback" / folder_name(student)
    written = []
    with parts.part(f"the first page of the feedback of {student}"):
        text = index_page(student, results, tasks, options.title)
        written.append(write_text(folder / "index.html", text))
    for result in results:
        task = by_slug[result.exercise]
        page = folder / f"{task.folder}.html"
        if not is_graded(result):
            page.unlink(missing_ok=True)  # from an earlier run; it no longer counts
            continue
        each = [_Page(page, result, task, options.hidden, _bags(result, out, options))]
        if options.replays_in != "feedback" and result.recordings is not None and _failed(result):
            mine = out / options.replays_in / folder.name / page.name
            bags = out / result.recordings
            each.append(_Page(mine, result, task, frozenset(), bags if bags.is_dir() else None))
        for wanted in each:
            written.append(wanted.path)
            keeps = pages.keeps_replays(wanted.path, *wanted.replays_made_of())
            if not pages.is_fresh(wanted.path, *wanted.made_of()):
                due.append(replace(wanted, keeps_replays=keeps and wanted.bags is not None))
    return written


def _failed(result: StoredResult) -> bool:
    return any(check.get("outcome") == "fail" for check in checks_of(as_graded(result)))


def _bags(result: StoredResult, out: Path, options: ResultOptions) -> Path | None:
    """Return the folder of the recordings to replay on a student's page, if there are any."""
    if not options.replays or result.recordings is None or not wants_bags(options.hidden):
        return None
    bags = out / result.recordings  # an absolute path stays itself
    return bags if bags.is_dir() else None


def _state(bags: Path) -> list[tuple[str, int, int]]:
    """Return names, sizes and times of the recordings' files, which show whether any changed."""
    files = sorted(path for path in bags.rglob("*") if path.is_file())
    stats = [(path.name, path.stat()) for path in files]
    return [(name, stat.st_size, stat.st_mtime_ns) for name, stat in stats]
