"""Write all results of a graded class."""

from __future__ import annotations

import contextlib
import hashlib
import json
import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

from grader.classroom.results.class_page import class_page
from grader.classroom.results.clean import folder_name
from grader.classroom.results.feedback import exercise_page, index_page, wants_bags
from grader.classroom.results.gradebooks import canvas_csv, moodle_csv, scores_csv
from grader.classroom.results.gradescope import results_json
from grader.classroom.results.junit import junit_xml
from grader.classroom.results.marks import Task, is_graded, tasks_of
from grader.classroom.results.options import ResultOptions
from grader.classroom.row import StoredResult
from grader.report.page import json_text, page_html

PAGES = ".pages.json"  # hashes of what each feedback page was made from
MANY = 20  # pages; for fewer, starting more processes does not pay
BOM = "\ufeff"  # without it Excel doesn't read the file as UTF-8


def write_results(
    results: Sequence[StoredResult], out: Path, options: ResultOptions | None = None
) -> list[Path]:
    """Write the class report, feedback, gradebooks and JUnit XML into `out`; return the files.

    The same results give the same files. Each file is replaced atomically, so nobody reads half of
    one.
    """
    options = options or ResultOptions()
    known = sorted(
        (result for result in results if not result.canary),
        key=lambda result: (result.student, result.exercise),
    )
    tasks = [replace(task, folder=folder_name(task.slug)) for task in tasks_of(known)]
    order = {task.slug: index for index, task in enumerate(tasks)}
    known.sort(key=lambda result: (result.student, order[result.exercise]))
    written = [
        _write(out / "class.html", class_page(known, tasks, options)),
        _write(out / "scores.csv", BOM + scores_csv(known, tasks)),
        _write(out / "canvas.csv", canvas_csv(known, tasks)),
        _write(out / "moodle.csv", moodle_csv(known, tasks)),
        _write(out / "junit.xml", junit_xml(known, tasks)),
    ]
    pages = _Pages(out / PAGES)
    due: list[_Page] = []
    for student, mine in groupby(known, key=lambda result: result.student):
        written += _write_student(student, list(mine), tasks, out, options, pages, due)
    _make(due, options.workers)
    pages.save()
    return written


@dataclass(frozen=True)
class _Page:
    """A feedback page to make."""

    path: Path
    result: StoredResult
    task: Task
    hidden: frozenset[str]
    bags: Path | None

    def make(self) -> None:
        _write(self.path, exercise_page(self.result, self.task, self.hidden, self.bags))


def _make(pages: Sequence[_Page], workers: int) -> None:
    """Make the pages, in several processes if there are many."""
    if workers == 1 or len(pages) < MANY:
        for page in pages:
            page.make()
        return
    # spawned: this process may have threads, of Dask or the progress bar
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        for _ in pool.map(_Page.make, pages, chunksize=4):
            pass


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

    def save(self) -> None:
        """Store the hashes, after the pages are written."""
        _write(self._file, json.dumps(self._now, indent=1, sort_keys=True) + "\n")

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
) -> list[Path]:
    by_slug = {task.slug: task for task in tasks}
    folder = out / "feedback" / folder_name(student)
    text = index_page(student, results, tasks, options.title)
    written = [_write(folder / "index.html", text)]
    for result in results:
        task = by_slug[result.exercise]
        page = folder / f"{task.folder}.html"
        if not is_graded(result):
            page.unlink(missing_ok=True)  # from an earlier run; it no longer counts
            continue
        bags = None
        if options.replays and result.recordings is not None and wants_bags(options.hidden):
            bags = out / result.recordings  # an absolute path stays itself
        bags = bags if bags is not None and bags.is_dir() else None
        written.append(page)
        hidden = sorted(options.hidden)
        made_of = (student, task.title, result.grading, result.file_names, result.finished)
        if not pages.is_fresh(page, *made_of, hidden, None if bags is None else _state(bags)):
            due.append(_Page(page, result, task, options.hidden, bags))
    handed_in = out / "gradescope" / folder_name(student) / "results.json"
    final = results_json(results, tasks, options.hidden)
    if final is None:
        handed_in.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # it is missing, or holds other files
            handed_in.parent.rmdir()
    else:
        written.append(_write(handed_in, json_text(final)))
    return written


def _state(bags: Path) -> list[tuple[str, int, int]]:
    """Return names, sizes and times of the recordings' files, which show whether any changed."""
    files = sorted(path for path in bags.rglob("*") if path.is_file())
    stats = [(path.name, path.stat()) for path in files]
    return [(name, stat.st_size, stat.st_mtime_ns) for name, stat in stats]


def _write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    part.write_bytes(text.encode("utf-8", "replace"))
    return part.replace(path)
