"""How results are written: title, notes, and what students don't see."""

import difflib
import json
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from grader.classroom.account import Account
from grader.classroom.amendments.log import Entry
from grader.course.exercises import find_exercise
from grader.errors import InputError
from grader.lms.book import StudentRow
from grader.lms.people import NOBODY, Roster

HIDE = ("nothing", "field", "worlds", "details")  # what each hides: grader.grading.withheld
OPTIONS = "options"  # what the store calls what is kept of these
KEPT = ("hide", "title", "notes", "account", "roster", "columns")


@dataclass(frozen=True)
class ResultOptions:
    """The instructor's choices, and what the batch knows."""

    hide: str = "nothing"  # one of HIDE, or several with commas: "field,worlds"
    title: str = "Bridging Python agents with rclpy"  # of the course
    notes: list[str] = field(default_factory=list)  # the batch's notes, a sentence each
    files: Sequence[str] = ()  # the tables and zips beside the report
    workers: int = 1  # processes that make the feedback pages
    account: Account = field(default_factory=Account)  # what became of each file
    students: Mapping[str, StudentRow] = field(default_factory=dict)  # by `StoredResult.student`
    roster: Roster = NOBODY
    columns: Mapping[str, str] = field(default_factory=dict)  # slug: title in the gradebook
    log: Sequence[Entry] = ()  # of what people have changed
    published: Collection[tuple[str, str]] | None = None  # pages; None: nothing was published yet

    def __post_init__(self) -> None:
        """Check the words of `hide`.

        Raises InputError: one is unknown.
        """
        for word in self.hidden:
            if word not in HIDE:
                near = difflib.get_close_matches(word, HIDE, n=1)
                hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(HIDE)}"
                raise InputError(f"hide: unknown word {word!r}; {hint}")

    @property
    def replays_in(self) -> str:
        """The folder of pages whose replays hide nothing from the instructor."""
        return "replays" if self.hidden - {"nothing"} else "feedback"

    @property
    def hidden(self) -> frozenset[str]:
        """The words of `hide`."""
        return frozenset(word.strip() for word in self.hide.split(",") if word.strip())


def kept_text(options: ResultOptions) -> str:
    """Return what the store keeps of these: marks change after the batch is over."""
    found = {name: getattr(options, name) for name in KEPT}
    return json.dumps(msgspec.to_builtins(found, enc_hook=str))  # names of files may be no text


def kept_options(text: str, students: Mapping[str, StudentRow]) -> ResultOptions:
    """Return the options of what was kept.

    Raises InputError: nothing was.
    """
    if not text:
        raise InputError("nothing was graded here yet: run `course autograde` with the submissions")
    options = msgspec.convert(json.loads(text), ResultOptions, dec_hook=_read)
    return replace(options, students=students, workers=os.cpu_count() or 1)


def column_titles(columns: Sequence[str]) -> dict[str, str]:
    """Return the titles by slug of what was given as "EXERCISE=TITLE".

    Raises InputError: it has another form, or there is no such exercise.
    """
    titles = {}
    for told in columns:
        name, sign, title = told.partition("=")
        if not sign or not title.strip():
            raise InputError(
                f"--column {told!r}: expected EXERCISE=TITLE, such as '1=Homework 1 (4711)'"
            )
        titles[find_exercise(name.strip()).slug] = title.strip()
    return titles


def _read(type_: type, value: Any) -> Any:
    if type_ is Path:
        return Path(value)
    raise NotImplementedError
