"""The queue and the results of a class, in one SQLite file that survives a kill at any moment.

Only the batch's own process writes. Each change is a transaction that is on disk when it returns
(WAL, synchronous=FULL), so a result is stored in full or not at all.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import sqlite3
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec

from grader.classroom.amendments.change import Change, Unread
from grader.classroom.amendments.log import Entry, active
from grader.classroom.row import ABSENT, GRADED, HELD, RUNNING, WAITING, StoredResult
from grader.errors import DiskFull, InputError, is_disk_full
from grader.lms.book import StudentRow
from grader.lms.told import words

SCHEMA = 5
TABLES = """
CREATE TABLE IF NOT EXISTS units (
    student TEXT NOT NULL, exercise TEXT NOT NULL, canary INTEGER NOT NULL DEFAULT 0,
    file_names TEXT NOT NULL DEFAULT '[]', input_hash TEXT NOT NULL, state TEXT NOT NULL,
    attempts INTEGER NOT NULL DEFAULT 0,    -- gradings begun
    deaths INTEGER NOT NULL DEFAULT 0,      -- of workers that were grading it
    unsure INTEGER NOT NULL DEFAULT 0,      -- gradings that could not judge
    quarantines INTEGER NOT NULL DEFAULT 0,
    verified INTEGER NOT NULL DEFAULT 0,    -- a good canary came after it
    grading TEXT, recordings TEXT, wall_s REAL NOT NULL DEFAULT 0,
    finished TEXT NOT NULL DEFAULT '', problem TEXT NOT NULL DEFAULT '',
    PRIMARY KEY (student, exercise)
) STRICT;
CREATE TABLE IF NOT EXISTS texts (
    student TEXT NOT NULL, exercise TEXT NOT NULL, name TEXT NOT NULL, text BLOB NOT NULL,
    PRIMARY KEY (student, exercise, name)
) STRICT;
CREATE TABLE IF NOT EXISTS kept (name TEXT PRIMARY KEY, text TEXT NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS amendments (
    number INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, who TEXT NOT NULL,
    what TEXT NOT NULL, why TEXT NOT NULL
) STRICT;
"""
MOST_WHY, MOST_NAME = 2000, 200  # [characters] of a reason, and of whose it is
UNREAD = (
    "entry {0} of the log of marks can't be read ({1}). Take it out of what counts, "
    '`course marks undo FOLDER {0} --why "can\'t be read"`, and then make that change anew'
)

SHARED = (
    "file_names", "state", "verified", "grading", "recordings", "wall_s", "finished", "problem",
)  # fmt: skip
NOTES, STUDENTS = "notes", "students"  # what is kept
Key = tuple[str, str]  # student, exercise
_CHANGES = msgspec.json.Decoder[Change](Change)


@dataclass(frozen=True)
class Counts:
    """How often things have gone wrong with one unit."""

    deaths: int
    unsure: int
    quarantines: int


class Store:
    """The file of one class.

    Raises InputError: the file is something else, or another version of the course made it.
    Raises DiskFull: no space was left.
    """

    def __init__(self, path: Path) -> None:
        self._db = sqlite3.connect(path, isolation_level=None)
        try:
            self._db.execute("PRAGMA journal_mode=WAL")
            self._db.execute("PRAGMA synchronous=FULL")
            version = self._db.execute("PRAGMA user_version").fetchone()[0]
            if version not in (0, SCHEMA):  # 0: an empty file
                self._db.close()
                raise InputError(
                    f"{path}: a store of schema {version}, expected {SCHEMA}; use the version of "
                    "the course that made it, or give another --out"
                )
            with self._change():
                for statement in filter(str.strip, TABLES.split(";")):
                    self._db.execute(statement)
                self._db.execute(f"PRAGMA user_version={SCHEMA}")
        except sqlite3.DatabaseError as error:
            self._db.close()
            if is_disk_full(error):
                raise DiskFull(f"{path}: no space is left on its disk; free some") from error
            raise InputError(f"{path}: expected the store of a graded class ({error})") from None

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._db.close()

    def enter(
        self,
        key: Key,
        input_hash: str,
        *,
        problem: str = "",
        absent: bool = False,
        compared: int | None = None,
    ) -> None:
        """Queue a unit unless it is stored unchanged; with a problem it is held, unless absent.

        Of the hash the first `compared` characters count; all, where none are said.
        """
        with self._change():
            old = self._db.execute(
                "SELECT input_hash, problem, state FROM units WHERE student=? AND exercise=?", key
            ).fetchone()
            same = old is not None and old[0][:compared] == input_hash[:compared]
            same = same and (old[2] == ABSENT) == absent
            if same and (not problem or old[1] == problem):
                return
            state = ABSENT if absent else HELD if problem else WAITING
            self._put(
                key, input_hash=input_hash, state=state, problem=storable(problem),
                verified=bool(problem) or absent, finished=_now() if problem else "",
            )  # fmt: skip

    def keep_only(self, keys: Collection[Key], exercises: Collection[str]) -> None:
        """Forget units of these exercises whose students are gone."""
        gone = [key for key in self._keys("canary=0") if key[1] in exercises and key not in keys]
        with self._change():
            for table in ("units", "texts"):
                self._db.executemany(f"DELETE FROM {table} WHERE student=? AND exercise=?", gone)

    def requeue_running(self) -> None:
        """Put what is marked as running back into the queue: whoever ran it is gone."""
        self._set(self._keys(f"state='{RUNNING}'"), state=WAITING)

    def share(self, leader: Key, key: Key, input_hash: str) -> bool:
        """Give a member what their group's leader got for the same files; False: nothing yet."""
        columns = ", ".join(SHARED)
        with self._change():
            done = self._db.execute(
                f"UPDATE units SET attempts=1, input_hash=?, ({columns}) = (SELECT {columns} FROM"
                " units WHERE student=? AND exercise=?) WHERE student=? AND exercise=? AND EXISTS"
                f" (SELECT 1 FROM units WHERE student=? AND exercise=? AND state IN ('{GRADED}',"
                f" '{HELD}') AND substr(input_hash, 1, {len(input_hash)})=?)",
                (input_hash, *leader, *key, *leader, input_hash),
            )
        return done.rowcount > 0

    def retry_held(self) -> None:
        """Put what is held after an attempt back into the queue."""
        self.again(self._keys(f"state='{HELD}' AND attempts>0 AND canary=0"))

    def again(self, keys: Iterable[Key]) -> None:
        """Put graded and held units back into the queue, as if nothing had gone wrong."""
        judged = set(self._keys(f"state IN ('{GRADED}', '{HELD}')"))
        self._set(
            judged.intersection(keys), state=WAITING, problem="", deaths=0, unsure=0,
            quarantines=0, verified=0, finished="",
        )  # fmt: skip

    def claim(self, key: Key, input_hash: str, file_names: Iterable[str]) -> None:
        with self._change():
            self._db.execute(
                "UPDATE units SET state=?, attempts=attempts+1, finished='', input_hash=?,"
                " file_names=? WHERE student=? AND exercise=?",
                (RUNNING, input_hash, json.dumps(list(file_names)), *key),
            )

    def finish(
        self,
        key: Key,
        grading: dict[str, Any] | None,
        *,
        problem: str = "",
        again: bool = False,
        recordings: str | None = None,
        wall_s: float = 0.0,
    ) -> None:
        """Store a result; one with a problem is held, or goes `again` into the queue."""
        self._set(
            [key],
            state=WAITING if again else HELD if problem else GRADED,
            unsure=self.counts(key).unsure + again,
            grading=None if grading is None else json.dumps(grading),
            problem=storable(problem), recordings=recordings, wall_s=wall_s,
            finished=_now(), verified=0,
        )  # fmt: skip

    def requeue(self, key: Key, *, death: bool = False) -> Counts:
        """Put a unit back into the queue, because its worker died or there was no room."""
        self._set([key], state=WAITING, deaths=self.counts(key).deaths + death)
        return self.counts(key)

    def hold(self, key: Key, problem: str) -> None:
        """Leave a unit to a person; its last grading is kept."""
        self._set([key], state=HELD, problem=storable(problem), finished=_now(), verified=1)

    def regraded(self, key: Key, grading: dict[str, Any], problem: str, input_hash: str) -> None:
        """Replace a grading by a new one of the same recordings."""
        self._set(
            [key], state=HELD if problem else GRADED, grading=json.dumps(grading),
            problem=storable(problem), input_hash=input_hash, finished=_now(),
        )  # fmt: skip

    def canary(self, key: Key, grading: dict[str, Any] | None, problem: str) -> None:
        """Store the latest grading of a known solution."""
        with self._change():
            self._put(
                key, canary=1, input_hash="", state=HELD if problem else GRADED, attempts=1,
                grading=json.dumps(grading), problem=storable(problem),
                finished=_now(), verified=1,
            )  # fmt: skip

    def verify(self, keys: Iterable[Key]) -> None:
        """Mark units as confirmed by a good canary after them."""
        self._set(keys, verified=1)

    def quarantine(self, keys: Iterable[Key]) -> None:
        """Put graded units back into the queue: the grader that judged them can't be trusted."""
        for key in keys:
            self._set(
                [key], state=WAITING, grading=None, recordings=None, finished="", problem="",
                quarantines=self.counts(key).quarantines + 1,
            )  # fmt: skip

    def keep_texts(self, texts: Mapping[Key, Mapping[str, bytes]]) -> None:
        """Keep what these students have handed in, in the place of what was kept."""
        rows = [(*key, storable(name), text) for key, files in texts.items()
                for name, text in files.items()]  # fmt: skip
        with self._change():
            self._db.executemany("DELETE FROM texts WHERE student=? AND exercise=?", list(texts))
            self._db.executemany("INSERT OR REPLACE INTO texts VALUES (?, ?, ?, ?)", rows)

    def texts(self, key: Key) -> dict[str, bytes]:
        """Return what a student has handed in, by the files' names."""
        rows = self._db.execute(
            "SELECT name, text FROM texts WHERE student=? AND exercise=? ORDER BY rowid", key
        )
        return {row[0]: bytes(row[1]) for row in rows}

    def note(self, text: str) -> None:
        """Keep a remark for the report."""
        self.keep(NOTES, json.dumps(list(dict.fromkeys([*self.notes(), text]))))

    def keep(self, name: str, text: str) -> None:
        """Keep a text, in the place of an older one of that name."""
        with self._change():
            self._db.execute("INSERT OR REPLACE INTO kept VALUES (?, ?)", (name, storable(text)))

    def kept(self, name: str) -> str:
        """Return a text that was kept; "" if there is none."""
        row = self._db.execute("SELECT text FROM kept WHERE name=?", (name,)).fetchone()
        return row[0] if row else ""

    def know(self, students: Iterable[StudentRow]) -> None:
        """Keep what is known of these students; what is known of others stays."""
        every = self.students() | {row.student: row for row in students}
        # as ASCII: names of files need not be UTF-8
        self.keep(STUDENTS, json.dumps(msgspec.to_builtins(list(every.values()))))

    def students(self) -> dict[str, StudentRow]:
        rows = msgspec.convert(json.loads(self.kept(STUDENTS) or "[]"), list[StudentRow])
        return {row.student: row for row in rows}

    def notes(self) -> list[str]:
        return list(json.loads(self.kept(NOTES) or "[]"))

    def waiting(self) -> list[Key]:
        """Return the queue, by exercise; what killed a worker or could not be judged comes last."""
        return self._keys(f"state='{WAITING}' AND canary=0", "deaths, unsure, exercise, student")

    def unverified(self, exercise: str) -> list[Key]:
        """Return what was graded since the last good canary."""
        keys = self._keys(f"verified=0 AND canary=0 AND state IN ('{GRADED}', '{HELD}')")
        return [key for key in keys if key[1] == exercise]

    def counts(self, key: Key) -> Counts:
        """Return how often things have gone wrong with a unit."""
        row = self._db.execute(
            "SELECT deaths, unsure, quarantines FROM units WHERE student=? AND exercise=?", key
        ).fetchone()
        return Counts(*row) if row else Counts(0, 0, 0)

    def results(self) -> list[StoredResult]:
        """Return the students' units, in order; known solutions are none of theirs."""
        rows = self._db.execute(
            "SELECT student, exercise, file_names, input_hash, state, grading, recordings,"
            " wall_s, attempts, problem, finished, verified OR NOT EXISTS"
            " (SELECT 1 FROM units AS known WHERE known.canary AND known.exercise=units.exercise)"
            " FROM units WHERE NOT canary ORDER BY student, exercise"
        )
        return [
            StoredResult(
                student, exercise, tuple(json.loads(names)), input_hash, state,
                grading and json.loads(grading), recordings and Path(recordings), wall_s,
                attempts, problem, finished, bool(verified),
            )
            for student, exercise, names, input_hash, state, grading, recordings, wall_s,
            attempts, problem, finished, verified in rows
        ]  # fmt: skip

    def log(self, change: Change, who: str, why: str) -> Entry:
        """Add an entry to the log of marks; it is on disk when this returns.

        Raises InputError: it could not be read back; or there is no reason, or it is too long.
        """
        why = words(why, MOST_WHY, "the reason (--why TEXT), which stays in the log")
        who, at = words(who, MOST_NAME, "who changes it (--by NAME)"), _now()
        try:
            text = msgspec.json.encode(change).decode()
        except UnicodeError:
            raise InputError(
                "expected names in UTF-8; rename the file, and take it in again"
            ) from None
        if _change_in(text) != change:
            raise InputError(f"expected finite numbers, not {text[:400]}")
        with self._change():
            number = self._db.execute(
                "INSERT INTO amendments (at, who, what, why) VALUES (?, ?, ?, ?)",
                (at, who, text, why),
            ).lastrowid
        return Entry(number or 0, at, who, change, why)

    def entries(self, undoing: int = 0) -> list[Entry]:
        """Return the log of marks, the oldest entry first; nothing removes or changes one.

        Raises InputError: one that counts can't be read, and `undoing` is not about such a one.
        """
        rows = self._db.execute("SELECT number, at, who, what, why FROM amendments ORDER BY number")
        found = [Entry(n, at, who, _change_in(what), why) for n, at, who, what, why in rows]
        unread = {each.number: each.change.problem for each in active(found)
                  if isinstance(each.change, Unread)}  # fmt: skip
        if unread and undoing not in unread:
            raise InputError(UNREAD.format(*next(iter(unread.items()))))
        return found

    def stamp(self) -> str:
        """Return what tells the stored results from later ones, without reading them."""
        rows = self._db.execute(
            "SELECT student, exercise, state, input_hash, attempts, finished, verified, problem,"
            " length(grading) FROM units ORDER BY student, exercise"
        )
        return hashlib.sha256(repr(rows.fetchall()).encode("utf-8", "replace")).hexdigest()

    def _put(self, key: Key, **columns: str | float) -> None:
        """Store a unit in the place of an older one."""
        names, marks = ", ".join(columns), ", ".join("?" * (len(columns) + 2))
        self._db.execute(
            f"INSERT OR REPLACE INTO units (student, exercise, {names}) VALUES ({marks})",
            (*key, *columns.values()),
        )

    def _set(self, keys: Iterable[Key], **columns: str | float | None) -> None:
        names = ", ".join(f"{name}=?" for name in columns)
        with self._change():
            self._db.executemany(
                f"UPDATE units SET {names} WHERE student=? AND exercise=?",
                [(*columns.values(), *key) for key in keys],
            )

    def _keys(self, where: str, order: str = "exercise, student") -> list[Key]:
        rows = self._db.execute(
            f"SELECT student, exercise FROM units WHERE {where} ORDER BY {order}"
        )
        return [(row[0], row[1]) for row in rows]

    @contextlib.contextmanager
    def _change(self) -> Iterator[None]:
        self._db.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._db.execute("COMMIT")
        except BaseException:
            if self._db.in_transaction:  # SQLite itself rolls back when the disk is full
                self._db.execute("ROLLBACK")
            raise


def _change_in(text: str) -> Change:
    try:
        change: Change = _CHANGES.decode(text)
        return change
    except msgspec.MsgspecError as error:
        return Unread(str(error))


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def storable(words: str) -> str:
    """Return text that can be stored: names of files need not be UTF-8, and SQLite's text is."""
    return words.encode("utf-8", "replace").decode("utf-8")
