"""The feedback that students may see: copies of the pages that were published, and of no other."""

from __future__ import annotations

import contextlib
import filecmp
import shutil
from collections.abc import Collection, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from grader.classroom.results.clean import folder_name
from grader.classroom.results.feedback import index_page
from grader.classroom.results.files import replacing, write_text
from grader.classroom.results.marks import Task, is_graded
from grader.classroom.results.missing import Parts
from grader.classroom.row import StoredResult

PUBLISHED = "published"

Keys = Collection[tuple[str, str]]  # student, exercise


def write_published(
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    out: Path,
    published: Keys,
    title: str,
    parts: Parts,
) -> list[Path]:
    """Bring the folder into step: what is published is there as it is now, and nothing else."""
    folder = out / PUBLISHED
    by_slug: Mapping[str, Task] = {task.slug: task for task in tasks}
    wanted: list[Path] = []
    shown = [each for each in results if (each.student, each.exercise) in published]
    for student, mine in groupby(shown, key=lambda result: result.student):
        with parts.part(f"the published feedback of {student}"):
            theirs, theirs_to_be = list(mine), folder / folder_name(student)
            text = index_page(student, theirs, tasks, title)
            wanted.append(write_text(theirs_to_be / "index.html", text))
            for result in filter(is_graded, theirs):
                page = f"{by_slug[result.exercise].folder}.html"
                wanted.append(_copied(out / "feedback" / folder_name(student), theirs_to_be, page))
    _remove_others(folder, set(wanted))
    return wanted


def _copied(source: Path, target: Path, page: str) -> Path:
    new = target / page
    if not (new.is_file() and filecmp.cmp(source / page, new, shallow=False)):
        with replacing(new) as file, (source / page).open("rb") as old:
            shutil.copyfileobj(old, file)
    return new


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
