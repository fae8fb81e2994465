"""The feedback that students may see: copies of the pages that were published, and of no other."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Collection, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from grader.classroom.marks import is_graded
from grader.classroom.results.feedback import index_page
from grader.classroom.results.files import write_text
from grader.classroom.row import StoredResult
from grader.lms.book import Task

PUBLISHED = "published"  # the folder


def write_published(
    results: Sequence[StoredResult],
    tasks: Mapping[str, Task],
    out: Path,
    published: Collection[tuple[str, str]],
    title: str,
) -> list[Path]:
    """Make the pages anew: what is published is there as it is now, and nothing else."""
    folder = out / PUBLISHED
    for page in folder.glob("*/*.html"):
        page.unlink()
    written = []
    shown = [each for each in results if (each.student, each.exercise) in published]
    for student, each in groupby(shown, key=lambda result: result.student):
        mine = list(each)
        index = index_page(student, mine, tasks, title)
        written.append(write_text(folder / student / "index.html", index))
        for name in [f"{one.exercise}.html" for one in mine if is_graded(one)]:
            if (out / "feedback" / student / name).is_file():  # else it could not be made
                shutil.copyfile(out / "feedback" / student / name, folder / student / name)
                written.append(folder / student / name)
    for emptied in (*folder.glob("*/"), folder):
        with contextlib.suppress(OSError):  # it holds pages, or somebody's own files
            emptied.rmdir()
    return written
