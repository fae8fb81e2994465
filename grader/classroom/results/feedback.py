"""A student's feedback: a page for each exercise, with replays, and an index page."""

import functools
import hashlib
import json
from collections.abc import Collection, Sequence
from pathlib import Path

from grader.classroom.amendments.marks import as_shown, points_of, task_of
from grader.classroom.results.files import write_text
from grader.classroom.results.page import render
from grader.classroom.row import StoredResult
from grader.errors import InputError
from grader.grading.withheld import hides_worlds, runs_for_students
from grader.lms.clean import one_line
from grader.recording import Recording
from grader.report.page import page_html, page_payload

LOST = (
    "The grader could not make these pages. That is its own fault, and your points count. Ask your "
    "instructor for the details."
)
LONGEST_STAMP = 200  # [bytes]


def write_page(path: Path, result: StoredResult, hidden: frozenset[str], bags: Path | None) -> Path:
    """Write the page of one grading, unless the one that is there was made of the same.

    A replay takes half a second to make, and a class has thousands.
    """
    if hides_worlds(hidden) or bags is None or not bags.is_dir():
        bags = None
    result = as_shown(result, hidden)  # the stamp is as public as the page
    changed = result.amended and (result.amended.points, result.amended.steps)
    made_of = (
        _look(), sorted(hidden), bags is None, result.finished, result.student,
        task_of(result.exercise).title, result.grading, result.file_names, changed,
    )  # fmt: skip
    text = json.dumps(made_of, sort_keys=True, default=str).encode("utf-8", "replace")
    stamp = f"<!-- {hashlib.sha256(text).hexdigest()} -->\n"
    if stamp != _stamp_of(path):
        write_text(path, exercise_page(result, hidden, bags) + stamp)
    return path


def exercise_page(result: StoredResult, hidden: Collection[str], bags: Path | None) -> str:
    """Return the page of one grading, of which all is for the student to see (`as_shown`)."""
    task = task_of(result.exercise)
    title = f"{task.title}: {one_line(result.student, 60)}"
    steps = result.amended.steps if result.amended else ()
    if result.grading is None:  # a person gave the points
        return render("words.html", title, heading=task.heading, sentences=steps)
    grading = dict(result.grading)
    if result.amended is not None and (points := points_of(result)) is not None:
        notes = [*(grading.get("notes") or ()), *steps]
        grading |= {"score": points, "max_score": task.points, "notes": notes}
    recordings = runs_for_students(_recordings(bags), hidden) if bags else []
    ask = {"student": result.student, "exercise": result.exercise}
    return page_html(page_payload(grading, recordings, title) | {"ask": ask})


def index_page(student: str, results: Sequence[StoredResult], course: str) -> str:
    """Return the page that a student opens first."""
    mine = [(result, task_of(result.exercise)) for result in results]
    title = f"{course}: {one_line(student)}"
    return render("index.html", title, course=course, student=student, results=mine)


def lost_page(student: str) -> str:
    """Return what takes the place of pages that could not be made."""
    return render("words.html", one_line(student), heading=one_line(student), sentences=[LOST])


def _recordings(bags: Path) -> list[Recording]:
    """Return the recordings to replay; none if they can't be read, so that there is a page."""
    from grader.recording.bag import load_all  # noqa: PLC0415  (rosbags: 0.2 s)

    try:
        return load_all(bags)
    except (InputError, OSError):
        return []


@functools.cache
def _look() -> str:
    """Return what a new player changes."""
    return page_html({})


def _stamp_of(page: Path) -> str:
    """Return a page's input hash (its last line); "" if there is none."""
    try:
        with page.open("rb") as file:
            file.seek(max(0, page.stat().st_size - LONGEST_STAMP))
            return file.read().decode("utf-8", "replace").splitlines(keepends=True)[-1]
    except (OSError, IndexError):
        return ""
