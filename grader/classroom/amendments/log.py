"""The log of changed marks: who changed what, when and why. It only grows.

It is a table of the class's store.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from datetime import UTC, datetime

import msgspec

from grader.classroom.amendments import change as changes
from grader.errors import InputError

TABLE = """
CREATE TABLE IF NOT EXISTS amendments (
    number INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, who TEXT NOT NULL,
    what TEXT NOT NULL, why TEXT NOT NULL
) STRICT"""
MAX_WORDS = 2000  # [characters] of a reason


@dataclass(frozen=True)
class Entry:
    number: int
    at: str  # UTC, ISO 8601
    who: str
    change: changes.Change
    why: str


class Log:
    """The log in an open store."""

    def __init__(
        self, db: sqlite3.Connection, transaction: Callable[[], AbstractContextManager[None]]
    ) -> None:
        self._db = db
        self._transaction = transaction

    def append(self, change: changes.Change, who: str, why: str) -> Entry:
        """Add an entry; it is on disk when this returns.

        Raises InputError: there is no reason, or it is too long.
        """
        why, who = " ".join(storable(why).split()), " ".join(storable(who).split())
        if not why or len(why) > MAX_WORDS:
            raise InputError(
                f"--why: expected the reason, at most {MAX_WORDS} characters; it stays in the log"
            )
        text = storable(msgspec.json.encode(change).decode())
        at = datetime.now(UTC).isoformat(timespec="seconds")
        with self._transaction():
            number = self._db.execute(
                "INSERT INTO amendments (at, who, what, why) VALUES (?, ?, ?, ?)",
                (at, who, text, why),
            ).lastrowid
        return Entry(number or 0, at, who, change, why)

    def entries(self) -> list[Entry]:
        """Return all entries, the oldest first.

        Raises InputError: one can't be read.
        """
        rows = self._db.execute(
            "SELECT number, at, who, what, why FROM amendments ORDER BY number"
        ).fetchall()
        try:
            return [Entry(row[0], row[1], row[2], _change(row[3]), row[4]) for row in rows]
        except msgspec.MsgspecError as error:
            raise InputError(f"the log of marks can't be read ({error})") from None


def active(entries: Sequence[Entry]) -> list[Entry]:
    """Return the entries that count, which are not undone."""
    undone = dict(undone_by(entries))
    return [
        each
        for each in entries
        if each.number not in undone and not isinstance(each.change, changes.Undo)
    ]


def undone_by(entries: Sequence[Entry]) -> list[tuple[int, int]]:
    """Return the entries that don't count, each with the one that undid it."""
    found: dict[int, int] = {}
    for entry in reversed(entries):
        if entry.number not in found and isinstance(entry.change, changes.Undo):
            found[entry.change.number] = entry.number
    return sorted(found.items())


def described(change: changes.Change) -> str:
    match change:
        case changes.SetCheck():
            words = f"{change.exercise}: {change.check} has {change.points:g} points"
        case changes.Waive():
            words = f"{change.exercise}: {change.check} does not count"
        case changes.Late():
            words = _late(change)
        case changes.Score():
            words = f"{change.exercise}: {change.points:g} points"
        case changes.Publish():
            words = f"feedback published: {', '.join(change.exercises) or 'all exercises'}"
        case changes.Assign():
            words = f"{change.was or ', '.join(change.entries)} is theirs"
        case changes.Accept():
            words = f"{change.exercise}: {change.file} counts as its file"
        case changes.Comment():
            words = f"{change.exercise}: on {change.file}, line {change.line}: {change.words}"
        case changes.Style():
            words = f"{change.exercise}: {style_words(change)}"
        case changes.Request():
            about = f", {change.check}" if change.check else ""
            words = f"{change.exercise}{about}: asks to look again: {change.words}"
        case changes.Answer():
            words = f"{change.exercise}: answer to request {change.request}: {change.words}"
        case changes.Undo():
            return f"entry {change.number} is undone"
    return f"{words} ({change.whom})"


def style_words(style: changes.Style) -> str:
    single = "; ".join(f"{name} {won:g} of {most:g}" for name, (won, most) in style.given.items())
    won, most = style.sums
    return f"style {won:g} of {most:g} ({single})"


def _late(rule: changes.Late) -> str:
    when = f"after {rule.deadline}" if rule.deadline else "what the platform calls late"
    words = f"{rule.exercise}: {when}, {rule.per_day:g} % of the points a day"
    words += f", {duration(rule.grace)} of grace" if rule.grace else ""
    words += f", at most {rule.cap:g} %" if rule.cap < 100 else ""
    return words + (f", times of a file for {len(rule.times)}" if rule.times else "")


def duration(seconds: float) -> str:
    """Return a time span in the largest unit that fits."""
    for size, unit in ((86400, "d"), (3600, "h"), (60, "min")):
        if seconds >= size and not seconds % size:
            return f"{seconds / size:g} {unit}"
    return f"{seconds:g} s"


def _change(text: str) -> changes.Change:
    found: changes.Change = msgspec.json.decode(text, type=changes.Change)
    return found


def storable(words: str) -> str:
    """Return text that can be stored: names of files need not be UTF-8, and SQLite's text is."""
    return words.encode("utf-8", "replace").decode("utf-8")
