"""The feedback that students may see: copies of the pages that were published, and of no other."""

from __future__ import annotations

import contextlib
import filecmp
import shutil
from collections.abc import Collection, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from grader.classroom.marks import is_graded
from grader.classroom.results.feedback import index_page
from grader.classroom.results.files import replacing, write_text
from grader.classroom.row import StoredResult
from grader.lms.book import Task
from grader.lms.clean import folder_name


def write_published(
    results: Sequence[StoredResult],
    tasks: Mapping[str, Task],
    out: Path,
    published: Collection[tuple[str, str]],
    title: str,
) -> list[Path]:
    """Bring the folder into step: what is published is there as it is now, and nothing else."""
    wanted: list[Path] = []
    shown = [each for each in results if (each.student, each.exercise) in published]
    for student, each in groupby(shown, key=lambda result: result.student):
        mine, folder = list(each), folder_name(student)
        index = index_page(student, mine, tasks, title)
        wanted.append(write_text(out / "published" / folder / "index.html", index))
        for result in filter(is_graded, mine):
            page = out / "feedback" / folder / f"{tasks[result.exercise].folder}.html"
            if page.is_file():  # else it could not be made
                wanted.append(_copied(page, out / "published" / folder / page.name))
    _remove_others(out / "published", set(wanted))
    return wanted


def _copied(source: Path, target: Path) -> Path:
    if not (target.is_file() and filecmp.cmp(source, target, shallow=False)):
        with replacing(target) as file, source.open("rb") as old:
            shutil.copyfileobj(old, file)
    return target


def _remove_others(folder: Path, wanted: Collection[Path]) -> None:
    if folder.is_symlink() or not folder.is_dir():
        return
    for place in folder.iterdir():
        if place.is_symlink() or not place.is_dir():
            continue
        for page in place.glob("*.html"):
            if page not in wanted:
                page.unlink()
        with contextlib.suppress(OSError):  # it still holds pages, or somebody's own files
            place.rmdir()
    with contextlib.suppress(OSError):
        folder.rmdir()
