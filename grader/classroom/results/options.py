"""How results are written: title, notes, and what students don't see."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grader.classroom.account import Account
from grader.classroom.amendments.log import Entry
from grader.classroom.results.alike import Alikes
from grader.classroom.roster import NOBODY, Roster
from grader.classroom.row import StudentRow
from grader.errors import InputError

HIDE = {
    "nothing": "students see everything",
    "field": "no field checks and none of their runs",
    "worlds": "no seeds and no replays, so that hidden worlds stay hidden",
    "details": "like worlds; of a failed check only its title and where to look next",
}

Sources = Mapping[tuple[str, str], Mapping[str, bytes]]


@dataclass(frozen=True)
class Linked:
    """A file or a folder of the results, as the report names it."""

    name: str
    what: str
    paths: tuple[str, ...]  # of the files, relative to the report


@dataclass(frozen=True)
class ResultOptions:
    """The instructor's choices, and what the batch knows."""

    hide: str = "nothing"  # one of HIDE, or several with commas: "field,worlds"
    title: str = "Bridging Python agents with rclpy"  # of the course
    notes: list[str] = field(default_factory=list)  # the batch's notes, a sentence each
    # (student, exercise): file name → content; without them there is no search for similar files
    sources: Sources = field(default_factory=dict)
    replays: bool = True  # put replays into the feedback pages (where there are recordings)
    files: Sequence[Linked] = ()  # what else is written
    workers: int = 1  # processes that make the feedback pages
    account: Account = field(default_factory=Account)  # what became of each file
    students: Mapping[str, StudentRow] = field(default_factory=dict)  # by `StoredResult.student`
    roster: Roster = NOBODY
    nbgrader: Path | None = None  # a gradebook of nbgrader's that gets the scores
    columns: Mapping[str, str] = field(default_factory=dict)  # slug: title in the gradebook
    log: Sequence[Entry] = ()  # of what people have changed
    published: Collection[tuple[str, str]] | None = None  # pages; None: nothing was published yet
    alikes: Alikes = field(default_factory=Alikes)
    section: str = ""  # the report is of this section; "": of the whole class
    anonymous: bool = False  # students are codes, and no page is about one of them

    def __post_init__(self) -> None:
        """Check the words of `hide`.

        Raises
        ------
        InputError
            One is unknown.
        """
        for word in self.hidden:
            if word not in HIDE:
                near = difflib.get_close_matches(word, HIDE, n=1)
                hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(HIDE)}"
                raise InputError(f"hide: unknown word {word!r}; {hint}")

    @property
    def root(self) -> str:
        """The way from the report to the folder of the class."""
        return "../" if self.section else ""

    @property
    def replays_in(self) -> str:
        """The folder of pages whose replays hide nothing from the instructor."""
        return "replays" if self.hidden - {"nothing"} else "feedback"

    @property
    def hidden(self) -> frozenset[str]:
        """The words of `hide`."""
        return frozenset(word.strip() for word in self.hide.split(",") if word.strip())
