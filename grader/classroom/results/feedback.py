"""A student's feedback: a page for each exercise, with replays, and an index page."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from grader.classroom.results import words
from grader.classroom.results.clean import one_line
from grader.classroom.results.marks import (
    Task,
    checks_of,
    is_absent,
    is_graded,
    is_held,
    points_of,
)
from grader.classroom.results.page import Element, document, el, name, table
from grader.classroom.results.withheld import for_students, hides_worlds, runs_for_students
from grader.classroom.row import StoredResult
from grader.errors import InputError
from grader.recording import Recording
from grader.report.page import page_html, page_payload
from grader.report.replay import moments_of

WAITING = "Not graded yet."
ABSENT = "Nothing handed in."
LOST = (
    "The grader could not make the page with your checks. That is its own fault, and your points "
    "count. Ask your instructor for the details."
)
HELD = "A person has to look at this one; it has no score yet, and nothing is lost."


def exercise_page(
    result: StoredResult,
    task: Task,
    hidden: Collection[str],
    bags: Path | None,
    before: Path | None = None,
) -> str:
    """Return the page of one grading, as its student may see it.

    Replays take half a second to make. They are taken from the page `before`, if there is one; the
    moments in them follow the grading.
    """
    if result.grading is None:
        return unjudged_page(result, task)
    grading = for_students(result.grading, result.file_names, hidden)
    if result.amended is not None and (points := points_of(result, task)) is not None:
        notes = [*(grading.get("notes") or ()), *result.amended.steps]
        grading |= {"score": points, "max_score": task.points, "notes": notes}
    title = f"{task.title}: {one_line(result.student, 60)}"
    if before is not None and (replays := _replays_of(before)):
        for replay in replays:
            replay["moments"] = moments_of(grading["checks"], replay["scenario"])
        return page_html({**page_payload(grading, [], title), "replays": replays})
    recordings = runs_for_students(_recordings(bags), hidden) if bags else []
    return page_html(page_payload(grading, recordings, title))


def _replays_of(page: Path) -> list[dict[str, Any]]:
    """Return the replays of a page that was made before; [] if they can't be read."""
    try:
        text = page.read_text("utf-8").partition('id="payload">')[2].partition("</script>")[0]
        found = json.loads(text)["replays"]
        return [dict(replay) for replay in found]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def unjudged_page(result: StoredResult, task: Task) -> str:
    """Return the page of one who has points and no grading: a person gave them."""
    steps = result.amended.steps if result.amended else ()
    return document(
        f"{task.title}: {one_line(result.student, 60)}",
        el("main", el("h1", task.heading), [el("p", step, class_="lead") for step in steps]),
    )


def lost_page(result: StoredResult, task: Task) -> str:
    """Return what takes the place of a page that could not be made."""
    return document(
        f"{task.title}: {one_line(result.student, 60)}",
        el(
            "main",
            el("h1", task.heading),
            el("p", LOST, class_="lead"),
            el("p", "Your points: ", words.points(points_of(result, task)), "."),
        ),
    )


def wants_bags(hidden: Collection[str]) -> bool:
    """Tell whether the pages show recordings."""
    return not hides_worlds(hidden)


def index_page(
    student: str, results: Sequence[StoredResult], tasks: Sequence[Task], course: str
) -> str:
    """Return the page that a student opens first."""
    by_slug = {result.exercise: result for result in results}
    rows = [_row(by_slug[task.slug], task) for task in tasks if task.slug in by_slug]
    headings = [("Exercise", ""), ("Points", "number"), ("Checks", ""), ("Field", "")]
    return document(
        f"{course}: {one_line(student)}",
        el(
            "header",
            el("p", one_line(course), class_="eyebrow"),
            el("h1", name(student, 80)),
            el("p", "Your results. Each exercise links to its checks.", class_="lead"),
            class_="top",
        ),
        el("main", el("section", table("Your results", headings, rows), class_="block")),
    )


def _row(result: StoredResult, task: Task) -> Element:
    if not is_graded(result):
        words = ABSENT if is_absent(result) else HELD if is_held(result) else WAITING
        return el("tr", el("th", task.heading, scope="row"), el("td", words, colspan=3))
    checks = [check for check in checks_of(result) if check.get("kind") != "field"]
    passed = sum(check.get("outcome") == "pass" for check in checks)
    points = points_of(result, task)
    ready = (result.grading or {}).get("field_ready")
    changed = el("p", " ".join(result.amended.steps), class_="often") if result.amended else None
    return el(
        "tr",
        el("th", el("a", task.heading, href=f"{task.folder}.html"), scope="row"),
        el("td", "not counted" if points is None else f"{points:g} / {task.points:g}",
           class_="number"),
        el("td", f"{passed} of {len(checks)} passed" if checks else "", changed),
        el("td", "" if ready is None else "field-ready" if ready else "not field-ready yet"),
    )  # fmt: skip


def _recordings(bags: Path) -> list[Recording]:
    """Return the recordings to replay; none if they can't be read, so that there is a page."""
    from grader.recording.bag import load_all  # noqa: PLC0415  (rosbags: 0.2 s)

    try:
        return load_all(bags)
    except (InputError, OSError):
        return []
