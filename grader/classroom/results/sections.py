"""A class report for each section of the roster, and the table that leads to them."""

from __future__ import annotations

import shutil
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from grader.classroom.results.clean import folder_name, one_line
from grader.classroom.results.marks import Task, is_absent, is_graded, is_held, points_of
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.page import Element, el, name, section, table
from grader.classroom.results.words import NOTHING, points
from grader.classroom.row import StoredResult

SECTIONS = "sections"  # the folder

Results = Sequence[StoredResult]


def sections_of(results: Results, options: ResultOptions) -> dict[str, list[StoredResult]]:
    """Return the results by section, in order; {} if the roster has none."""
    if options.anonymous or options.section:
        return {}
    found: dict[str, list[StoredResult]] = {}
    for result in results:
        row = options.students.get(result.student)
        if row is not None and row.section:
            found.setdefault(row.section, []).append(result)
    return dict(sorted(found.items()))


def of_section(options: ResultOptions, title: str) -> ResultOptions:
    """Return how a section's report is written: without what is about the whole class."""
    return replace(
        options, section=title, notes=[], files=(), log=(), account=type(options.account)()
    )


def page_of(title: str) -> str:
    """Return where a section's report is, seen from the class report."""
    return f"{SECTIONS}/{folder_name(title)}.html"


def remove_old(out: Path) -> None:
    """Remove the reports of an earlier roster."""
    shutil.rmtree(out / SECTIONS, ignore_errors=True)


def sections_table(found: Mapping[str, Results], tasks: Sequence[Task]) -> Element | None:
    """Return the section of the class report; None if there are no sections."""
    if not found:
        return None
    rows = []
    for title, mine in found.items():
        link = el("a", name(one_line(title, 80), 80), href=page_of(title))
        for index, task in enumerate(tasks):
            theirs = [result for result in mine if result.exercise == task.slug]
            scores = [p for p in (points_of(result, task) for result in theirs) if p is not None]
            number = "number"
            rows.append(
                el(
                    "tr",
                    el("th", link if not index else name(title, 80), scope="row"),
                    el("td", task.heading),
                    el("td", str(sum(map(is_graded, theirs))), class_=number),
                    el("td", str(sum(map(is_held, theirs))), class_=number),
                    el("td", str(sum(map(is_absent, theirs))), class_=number),
                    el("td", points(statistics.median(scores)) if scores else NOTHING,
                       class_=number),
                    el("td", points(statistics.fmean(scores)) if scores else NOTHING,
                       class_=number),
                )
            )  # fmt: skip
    number = "number"
    headings = [
        ("Section", ""), ("Exercise", ""), ("Graded", number), ("Held", number),
        ("Not handed in", number), ("Median", number), ("Mean", number),
    ]  # fmt: skip
    return section(
        "sections",
        "Sections",
        "Each section of the roster has a report of its own.",
        table("Sections of the roster", headings, rows),
    )
