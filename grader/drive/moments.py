"""Moments of a drive that somebody looks into, as tables: for the terminal and for the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rich.markup import escape
from rich.table import Table

from grader.errors import InputError
from grader.recording import Recording
from grader.report.terminal import Console
from grader.trial.virtual_time import asked_at
from rclpy_virtual_time import Link, readable
from sim.scenario import Scenario

LIVE = "No moment can be looked into: in real time another run would be another."
NOTHING = "Nothing of the node had run by {}."
NO_SUCH = "{}: expected a function that had run by then, such as {}."
CALLED_BY = {
    "subscription": "a message on {}",
    "timer": "its timer of {}",
    "service": "a request on {}",
    "answer": "a future that is done",
    "task": "a task that was made",
    "other": "another event",
    "program": "nobody: the program itself runs",
}
BEGAN, OTHERS = "Began", "Also by then"
NEVER_MARKED = (BEGAN, OTHERS, "header")  # a stamp is another each time
STATE, SENT, CAME = "What it keeps", "What it sent", "What came: {}"
MARKS = ("* changed", "* different")
GONE = "Variables are gone once their function has returned."

Key = tuple[int, str, str]  # where a row stands, its part, its name
Cell = tuple[str, bool]  # a text, and whether the callback changed it


def tables_of(
    recording: Recording, at: Sequence[float], callback: str = ""
) -> list[dict[str, Any]]:
    """Return a table for each program: `title`, `columns`, `place`, `functions`, and `rows`.

    A row has the `part` of the table, a `name`, a text for each of the moments `at` [s], and
    whether it is `marked`: what is different between two moments; of one, what the callback
    changed. The earlier moment is first, with the callback that began last by then; of the later
    it is the same one's last. `place` is that of its function: "node.py, line 12". Where a function
    of the name `callback` is among those that ran, `functions`, the table is about that one.
    """
    at = sorted(at)
    asked = [asked_at(time, recording.scenario) for time in at]
    programs = dict.fromkeys(file for file, _ in recording.moments if at)
    tables = []
    for program in programs:
        by_time = [
            [each for file, each in recording.moments if file == program and each.asked == time]
            for time in asked
        ]
        ran = [moment.place for each in by_time for moment in reversed(each)]
        place = next((each for each in ran if each.function == callback), ran[0])
        cells = [dict(_cells(each, place)) for each in by_time]
        names = sorted(dict.fromkeys(key for each in cells for key in each), key=lambda key: key[0])
        rows = [_row(key, [each.get(key, ("", False)) for each in cells]) for key in names]
        columns = [f"last by {time:.2f} s" for time in at]
        title = f"What ran in {program}" if len(programs) > 1 else "What ran"
        functions = list(dict.fromkeys([place.function, *(each.function for each in ran)]))
        named = {"title": title, "columns": columns, "place": place.line, "functions": functions}
        tables.append({**named, "rows": rows})
    return tables


def check_moments(at: Sequence[float], scenario: Scenario) -> None:
    """Raise InputError: these are no moments of a drive, or more than two."""
    if len(at) > 2:
        raise InputError(f"at: expected one moment, or two to compare, and not {len(at)}")
    if odd := [time for time in at if not 0 <= time <= scenario.duration]:
        raise InputError(f"at {odd[0]:g} s: expected a moment of the {scenario.duration:g} s drive")


def _row(key: Key, cells: Sequence[Cell]) -> dict[str, Any]:
    _, part, name = key
    texts = [readable(text) for text, _ in cells]
    changed = cells[0][1] if len(cells) == 1 else len(set(texts)) > 1 and name not in NEVER_MARKED
    return {"part": part, "name": readable(name), "cells": texts, "marked": changed}


def _cells(moments: Sequence[Link.Moment], place: Any) -> Iterator[tuple[Key, Cell]]:
    """Yield what is known of a callback, of that place if it ran, and which others ran by then.

    That is: where it stands and its name; its text, and whether it changed.
    """
    if not moments:
        return
    moment = next((each for each in reversed(moments) if each.place == place), moments[-1])
    others = (each for each in reversed(moments) if each is not moment)
    where = moment.place
    of = f" of {moment.node}" if moment.node else ""
    lasted = f", and took {moment.lasted / 1e9:.3f} s" if moment.lasted else ""
    lasted = ", and was not over in the end" if moment.lasted is None else lasted
    facts = {
        "Function": ", ".join(filter(None, [f"{where.function}{of}", where.line])),
        "Called by": CALLED_BY[moment.kind].format(moment.about),
        BEGAN: f"{moment.time / 1e9:.3f} s{lasted}",
        OTHERS: ", ".join(f"{each.place.function} {each.time / 1e9:.3f} s" for each in others),
        "Answered": moment.answered,
        "Raised": ", ".join([moment.raised, *(each.line for each in moment.raised_in[:1])]),
    }
    for name, text in facts.items():
        if text:
            yield (0, "", name), (text, False)
    yield from _locals(0, "", moment.raised_in)
    for value in moment.values:
        changed = value.before != value.text
        was = f"{value.before} → " if changed and value.before else ""
        yield (1, STATE, value.name), (f"{was}{value.text}", changed)
    for number, sent in enumerate(moment.sent, 1):
        part = f"{SENT}, {number}" if len(moment.sent) > 1 else SENT
        later = f", at {sent.time / 1e9:.3f} s" if sent.time != moment.time else ""
        by = f" by {sent.by}" if sent.by else ""
        line = sent.places[0].line if sent.places else "?"
        yield (1 + number, part, sent.topic), (f"{sent.text}{by}, {line}{later}", False)
        yield from _locals(1 + number, part, sent.places)
    if moment.more:
        yield (50, SENT, "and before"), (f"{moment.more:,} more", False)
    for field in moment.fields:
        yield (60, CAME.format(moment.message), field.name), (field.text, False)


def _locals(order: int, part: str, places: Sequence[Any]) -> Iterator[tuple[Key, Cell]]:
    for place in places:
        for value in place.values:
            yield (order, part, f"{value.name} in {place.function}"), (value.text, False)


def print_moments(recording: Recording, at: Sequence[float], callback: str = "") -> None:
    """Print what ran by each of these times [s], side by side; of a `callback`, if it is named."""
    tables = tables_of(recording, at, callback)
    console = Console(highlight=False)
    functions = list(dict.fromkeys(name for table in tables for name in table["functions"]))
    if callback and functions and callback not in functions:
        known = escape(readable(NO_SUCH.format(callback, ", ".join(functions))))
        console.print(f"  {known}", soft_wrap=True)
    if at and not tables:
        console.print(f"  {LIVE if recording.live else NOTHING.format(f'{max(at):.2f} s')}")
    for table in tables:
        console.print(f"\n[bold]{escape(readable(table['title']))}[/]")
        console.print(f"  {MARKS[len(at) - 1]}. {GONE}", style="dim")
        grid = Table.grid(padding=(0, 2, 0, 0))
        for _ in range(2 + len(at)):
            grid.add_column(overflow="fold")
        grid.add_row("", *(f"[bold]{each}[/]" for each in ["", *table["columns"]]))
        part = ""
        for row in table["rows"]:
            if row["part"] != part:
                part = row["part"]
                grid.add_row("", f"[bold]{escape(part)}[/]")
            mark = "*" if row["marked"] else ""
            grid.add_row(
                f" {mark}", escape(row["name"]), *(escape(each) or "-" for each in row["cells"])
            )
        console.print(grid)
