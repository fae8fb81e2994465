"""Mistakes from public questions and issues, as edits of the references: README.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from grader.authoring.edits import edited
from grader.course.exercises import Exercise
from sim.toml_input import convert, parse_toml, read_toml

HERE = Path(__file__).parent
SYNTAX = "syntax"  # the class of mistakes that do not compile


class Mistake(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One mistake as it stands in the list."""

    kind: str = msgspec.field(name="class")
    mistake: str  # one sentence
    cause: str  # what a good teacher would say the cause is
    source: str  # title of the question, issue or page
    address: str  # of the source
    edit: str  # docs/add-an-exercise.md
    base: str = ""  # the file that is edited, where it is not the list's
    requires: tuple[str, ...] = ()  # modules without which it makes no difference


class _List(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    base: str
    mistake: dict[str, dict[str, Any]]


def mistakes(exercise: Exercise) -> dict[str, Mistake]:
    """Return an exercise's mistakes by name, in the order of the list.

    Raises
    ------
    InputError
        The list is broken.
    """
    path = HERE / f"{exercise.slug}.toml"
    doc = convert(parse_toml(read_toml(path), str(path)), _List, str(path))
    found = {
        name: convert(table, Mistake, str(path), at=("mistake", name))
        for name, table in doc.mistake.items()
    }
    return {
        name: msgspec.structs.replace(mistake, base=mistake.base or doc.base)
        for name, mistake in found.items()
    }


def submission(exercise: Exercise, mistake: Mistake) -> dict[str, str]:
    """Return all files of the exercise: the reference's, one of them with the mistake.

    Raises
    ------
    EditError
        The edit does not fit in exactly one place.
    """
    files = {file: (exercise.solutions / file).read_text("utf-8") for file in exercise.files}
    lines = edited(files[mistake.base].splitlines(), mistake.edit, mistake.base)
    return {**files, mistake.base: "".join(f"{line}\n" for line in lines)}
