"""The log of changed marks: who changed what, when and why. It only grows.

It is a table of the class's store. Each entry is sealed with a hash of itself and of the seal
before it, so that an entry that was edited, removed or put in with another program is noticed. The
seal is no signature: who can write the file and knows this code can make new seals.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import msgspec

from grader.classroom.amendments.change import Change, Late, Publish, Score, SetCheck, Undo, Waive
from grader.errors import InputError

TABLE = """
CREATE TABLE IF NOT EXISTS amendments (
    number INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, who TEXT NOT NULL,
    what TEXT NOT NULL, why TEXT NOT NULL, seal TEXT NOT NULL
) STRICT"""
FREEZE = (
    "CREATE TRIGGER IF NOT EXISTS amendments_{0} BEFORE {0} ON amendments"
    " BEGIN SELECT RAISE(ABORT, 'the log of marks only grows'); END"
)
MAX_WORDS = 2000  # [characters] of a reason

BROKEN = "this entry was changed after it was made"
GONE = "this entry was removed"


@dataclass(frozen=True)
class Entry:
    """One entry of the log."""

    number: int
    at: str  # UTC, ISO 8601
    who: str
    change: Change | None  # None: it can't be read
    why: str
    problem: str = ""  # BROKEN or GONE; "" if it is as it was made
    text: str = ""  # as it is stored


class Log:
    """The log in an open store."""

    def __init__(
        self, db: sqlite3.Connection, transaction: Callable[[], AbstractContextManager[None]]
    ) -> None:
        self._db = db
        self._transaction = transaction

    def prepare(self) -> None:
        """Make the table, and let nobody change its rows."""
        self._db.execute(TABLE)
        for verb in ("UPDATE", "DELETE"):
            self._db.execute(FREEZE.format(verb))

    def append(self, change: Change, who: str, why: str) -> Entry:
        """Add an entry; it is on disk when this returns.

        Raises
        ------
        InputError
            There is no reason, or it is too long.
        """
        why, who = " ".join(_text(why).split()), " ".join(_text(who).split())
        if not why or len(why) > MAX_WORDS:
            raise InputError(
                f"--why: expected the reason, at most {MAX_WORDS} characters; it stays in the log"
            )
        text = _text(msgspec.json.encode(change).decode())
        if _change(text) is None:  # such as a number that JSON has not
            raise InputError(f"expected a change that can be read again, got {described(change)}")
        at = datetime.now(UTC).isoformat(timespec="seconds")
        with self._transaction():
            last = self._db.execute(
                "SELECT number, seal FROM amendments ORDER BY number DESC LIMIT 1"
            ).fetchone()
            number = max(last[0] if last else 0, self._given()) + 1
            seal = _seal(last[1] if last else "", number, at, who, text, why)
            self._db.execute(
                "INSERT INTO amendments (number, at, who, what, why, seal)"
                " VALUES (?, ?, ?, ?, ?, ?)",
                (number, at, who, text, why, seal),
            )
        return Entry(number, at, who, change, why, text=text)

    def entries(self) -> list[Entry]:
        """Return all entries, the oldest first; one that is gone has its place."""
        rows = self._db.execute(
            "SELECT number, at, who, what, why, seal FROM amendments ORDER BY number"
        ).fetchall()
        found: list[Entry] = []
        before = ""
        for number, at, who, text, why, seal in rows:
            removed = range(len(found) + 1, number)
            found += [Entry(each, "", "", None, "", GONE) for each in removed]
            # after one that is gone, the seal before is not known
            good = seal == _seal(before, number, at, who, text, why) or bool(removed)
            change = _change(text)
            problem = "" if good and change is not None else BROKEN
            found.append(Entry(number, at, who, change, why, problem, text))
            before = seal
        found += [
            Entry(each, "", "", None, "", GONE) for each in range(len(found) + 1, self._given() + 1)
        ]
        return found

    def _given(self) -> int:
        """Return the highest number that was ever given."""
        row = self._db.execute("SELECT seq FROM sqlite_sequence WHERE name='amendments'").fetchone()
        return int(row[0]) if row else 0


def active(entries: Sequence[Entry]) -> list[Entry]:
    """Return the entries that count, which are not undone.

    Raises
    ------
    InputError
        One was changed or removed by hand, and nobody has undone it.
    """
    undone: set[int] = set()
    kept = []
    for entry in reversed(entries):
        if entry.number in undone:
            continue
        if entry.problem:
            raise InputError(
                f"entry {entry.number} of the log of marks: {entry.problem}. No score may hang on "
                "it: bring store.sqlite back from a copy, or say that it does not count, with "
                f"`course marks undo FOLDER {entry.number} --why REASON`"
            )
        if isinstance(entry.change, Undo):
            undone.add(entry.change.number)
        else:
            kept.append(entry)
    return kept[::-1]


def undone_by(entries: Sequence[Entry]) -> list[tuple[int, int]]:
    """Return the entries that don't count, each with the one that undid it."""
    found: dict[int, int] = {}
    for entry in reversed(entries):
        if entry.number not in found and isinstance(entry.change, Undo):
            found[entry.change.number] = entry.number
    return sorted(found.items())


def broken(entries: Sequence[Entry]) -> list[Entry]:
    """Return the entries that were changed or removed by hand and that nobody has undone."""
    undone = {number for number, _ in undone_by(entries)}
    return [entry for entry in entries if entry.problem and entry.number not in undone]


def described(change: Change | None) -> str:
    """Return in words what a change is."""
    match change:
        case SetCheck():
            words = f"{change.exercise}: {change.check} has {change.points:g} points"
        case Waive():
            words = f"{change.exercise}: {change.check} does not count"
        case Late():
            words = _late(change)
        case Score():
            words = f"{change.exercise}: {change.points:g} points"
        case Publish():
            words = f"feedback published: {', '.join(change.exercises) or 'all exercises'}"
        case Undo():
            return f"entry {change.number} is undone"
        case _:
            return "not readable"
    return f"{words} ({change.whom})"


def _late(rule: Late) -> str:
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


def _change(text: str) -> Change | None:
    try:
        found: Change = msgspec.json.decode(text, type=Change)
    except (msgspec.MsgspecError, ValueError):
        return None
    return found


def _seal(*parts: Any) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def _text(told: str) -> str:
    return told.encode("utf-8", "replace").decode("utf-8")
