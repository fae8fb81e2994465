"""What results are written with, kept in the store: marks change after the batch is over."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from grader.classroom.account import Account
from grader.classroom.results.options import ResultOptions
from grader.classroom.roster import NOBODY, Roster
from grader.classroom.row import StudentRow
from grader.errors import InputError

OPTIONS = "options"  # what the store calls it


class _Kept(msgspec.Struct, frozen=True):
    """`ResultOptions` without what is elsewhere: students in the store, sources nowhere."""

    hide: str = "nothing"
    title: str = ""
    notes: list[str] = []
    account: Account = Account()
    roster: Roster = NOBODY
    nbgrader: str = ""
    columns: dict[str, str] = {}


def kept_text(options: ResultOptions) -> str:
    """Return what is to be kept."""
    found = _Kept(
        options.hide,
        options.title,
        options.notes,
        options.account,
        options.roster,
        str(options.nbgrader.resolve()) if options.nbgrader else "",
        dict(options.columns),
    )
    return json.dumps(msgspec.to_builtins(found, enc_hook=str))  # names of files may be no text


def kept_options(text: str, students: Mapping[str, StudentRow]) -> ResultOptions:
    """Return the options of what was kept.

    Raises
    ------
    InputError
        Nothing was, by an older version of the course.
    """
    try:
        found = msgspec.convert(json.loads(text), _Kept, dec_hook=_read)
    except (msgspec.MsgspecError, ValueError):
        raise InputError(
            "this class was graded by an earlier version of the course: run `course autograde` "
            "once more with the same submissions; it grades only what is new"
        ) from None
    return ResultOptions(
        hide=found.hide,
        title=found.title,
        notes=found.notes,
        account=found.account,
        roster=found.roster,
        nbgrader=Path(found.nbgrader) if found.nbgrader else None,
        columns=found.columns,
        students=students,
        workers=os.cpu_count() or 1,  # on any system
    )


def _read(type_: type, value: Any) -> Any:
    if type_ is Path:
        return Path(value)
    raise NotImplementedError
