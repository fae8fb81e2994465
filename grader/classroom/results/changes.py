"""The class report's section about marks that people have changed."""

from __future__ import annotations

from collections.abc import Sequence

from grader.classroom.amendments.log import Entry, described, undone_by
from grader.classroom.results.clean import one_line
from grader.classroom.results.page import Element, el, name, section, table
from grader.classroom.results.words import moment

MOST = 50  # entries on the page


def changes(log: Sequence[Entry]) -> Element | None:
    """Return the newest entries of the log; None if there are none."""
    if not log:
        return None
    undone = dict(undone_by(log))
    rows = [
        el(
            "tr",
            el("th", str(entry.number), scope="row", class_="number"),
            el("td", moment(entry.at)),
            el("td", name(entry.who, 40)),
            el("td", el("span", one_line(described(entry.change), 240), dir="auto", class_="said"),
               el("p", f"“{one_line(entry.why, 300)}”", dir="auto", class_="often")),
            el("td", "undone" if entry.number in undone else "counts"),
        )
        for entry in log[: -MOST - 1 : -1]
    ]  # fmt: skip
    more = f" The newest {MOST} of {len(log)}." if len(log) > MOST else ""
    return section(
        "changes",
        "Changed marks",
        f"What people changed after the grading, the newest first.{more} The command course report "
        "prints all of it; course marks undo takes an entry back.",
        table(
            "The log of marks",
            [("No.", "number"), ("When", ""), ("Who", ""), ("What and why", "wide"), ("State", "")],
            rows,
            stacks=True,
        ),
    )
