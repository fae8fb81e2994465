"""Wrong programs as edits of right ones: read an exercise's `mutants.diff`, render its mutants.

A mutant is one mistake, written as a small diff of a program in `solutions/EXERCISE/`, below the
checks that must catch it and a sentence::

    base: variants/compact.py

    mutant narrow_cone fails sees_sides, field_lds01
    Looks only ±45° ahead.
    -            if abs(angle) > math.pi / 2:
    +            if abs(angle) > math.pi / 4:

`grader.claims.edits` says how an edit is read. Below the sentence a mutant may name a `base` of its
own, in `requires` the modules without which it would fail otherwise, and in `why` what it is needed
for: three mutants of a check are enough without. It stands for the same file of the exercise as its
base. A line that begins with `#` is a comment.

`python -m grader.authoring.mutants` lists, prints and counts them.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import Annotated, Any

import msgspec

from grader.claims.edits import EditError, edited
from grader.course.exercises import Exercise
from grader.errors import GraderError, InputError
from sim.toml_input import convert, nearest

CATALOGUE = "mutants.diff"
FIELD = "field_"  # begins the names of field checks

Text = Annotated[str, msgspec.Meta(min_length=1)]


class _Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A mutant as it stands in the catalogue."""

    mistake: Text
    fails: Annotated[tuple[str, ...], msgspec.Meta(min_length=1)]
    edit: Text
    base: str = ""
    requires: tuple[str, ...] = ()
    why: str = ""


_CHECK = re.compile(r"(?m)^(?:def )?test_(\w+)(?:\(| =)")  # written out, or made by a suite


@dataclass(frozen=True)
class Mutant:
    """A wrong program."""

    name: str
    mistake: str  # one sentence
    fails: frozenset[str]  # checks, core and field
    requires: frozenset[str]  # modules without which it can't be graded
    file: str  # of the exercise, that it stands for
    text: str
    why: str = ""  # it is needed, where the checks that it names have enough without it


@dataclass(frozen=True)
class _Base:
    name: str  # "variants/compact.py"
    file: str  # of the exercise, that it stands for
    lines: list[str]  # without the docstring


def mutants(exercise: Exercise, folder: Path | None = None) -> list[Mutant]:
    """Return the mutants of an exercise in the order of its catalogue; none without one.

    Raises InputError: the catalogue is broken: the file, the mutant and what is wrong with it.

    Parameters
    ----------
    exercise
        Whose mutants.
    folder
        Its solutions, where they are not the course's own.
    """
    folder = folder or exercise.solutions
    path = folder / CATALOGUE
    if not path.is_file():
        return []
    text = re.sub(r"(?m)^#.*\n", "", path.read_text("utf-8"))
    head, *parts = re.split(r"(?m)^mutant ", text)
    usual = re.fullmatch(r"base: (\S+)", head.strip())
    if not usual:
        raise InputError(f"{path}: {head.strip()!r}: expected `base: FILE` above the first mutant")
    known = check_names(exercise)
    bases: dict[str, _Base] = {}
    found: dict[str, Mutant] = {}
    for part in parts:
        name, table = _table(part)
        entry = convert(table, _Entry, str(path), at=("mutant", name))
        where = f"{path}: mutant.{name}"
        if name in found:
            raise InputError(f"{where} is there twice")
        for check in entry.fails:
            if check not in known:
                raise InputError(f"{where}: no check {check!r}{nearest(check, known)}")
        base = entry.base or usual[1]
        if base not in bases:
            bases[base] = _read_base(exercise, folder, base, where)
        found[name] = _render(name, entry, bases[base], exercise.files[0], where)
    return list(found.values())


def find_mutant(exercise: Exercise, name: str) -> Mutant:
    """Return the mutant of that name.

    Raises InputError: there is none, or the catalogue is broken.
    """
    found = {mutant.name: mutant for mutant in mutants(exercise)}
    if name not in found:
        hint = nearest(name, found)
        raise InputError(f"{exercise.slug} has no mutant {name!r}{hint}")
    return found[name]


def submission_of(exercise: Exercise, mutant: Mutant | None) -> dict[str, str]:
    """Return all files of the exercise: the mutant's, if there is one, and the reference's."""
    reference = {file: (exercise.solutions / file).read_text("utf-8") for file in exercise.files}
    return {**reference, **({mutant.file: mutant.text} if mutant else {})}


def stands_for(exercise: Exercise, path: Path) -> str:
    """Return the file of the exercise that a program stands for.

    It has that file's name, or names it in its docstring (`file: client.py`); else it is the first.

    Raises GraderError: the exercise has no such file.
    """
    if path.name in exercise.files:
        return path.name
    doc = ast.get_docstring(ast.parse(path.read_bytes())) or ""
    said = re.search(r"^file:\s*(\S+)$", doc, re.MULTILINE)
    file = said[1] if said else exercise.files[0]
    if file not in exercise.files:
        expected = ", ".join(exercise.files)
        raise GraderError(f"{path}: stands for {file}; expected one of {expected}")
    return file


def check_names(exercise: Exercise) -> frozenset[str]:
    """Return the names of an exercise's checks, core and field."""
    texts = (file.read_text("utf-8") for file in exercise.judge.glob("test_*.py"))
    return frozenset(name for text in texts for name in _CHECK.findall(text))


# --- rendering ------------------------------------------------------------------------------------


def _table(part: str) -> tuple[str, dict[str, Any]]:
    """Return a mutant's name, and what the catalogue says of it by the keys of `_Entry`."""
    first, *lines = part.rstrip().split("\n")
    name, _, checks = first.partition(" fails ")
    above = list(takewhile(lambda line: line[:1] not in "-+ @", lines))
    mistake, *notes = above or [""]
    table: dict[str, Any] = {
        key: value for key, _, value in (note.partition(": ") for note in notes)
    }
    if "requires" in table:
        table["requires"] = table["requires"].split(", ")
    table |= {"fails": re.findall(r"\w+", checks), "mistake": mistake}
    return name, {**table, "edit": "\n".join(lines[len(above) :])}


def _read_base(exercise: Exercise, folder: Path, base: str, where: str) -> _Base:
    path = folder / base
    if not path.is_file():
        there = (file.relative_to(folder).as_posix() for file in folder.rglob("*.py"))
        raise InputError(f"{where}: no base {base!r} in {folder}{nearest(base, there)}")
    text = path.read_text("utf-8")
    first = ast.parse(text).body[0]
    is_doc = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
    start = first.end_lineno or 0 if is_doc else 0
    return _Base(base, stands_for(exercise, path), text.splitlines()[start:])


def _render(name: str, entry: _Entry, base: _Base, first: str, where: str) -> Mutant:
    """Return the mutant: its docstring, and the base with the edit."""
    try:
        lines = edited(base.lines, entry.edit, base.name)
    except EditError as error:
        raise InputError(f"{where}: {error}") from None
    mistake = " ".join(entry.mistake.split())
    notes = {"file": [base.file] if base.file != first else [], "requires": entry.requires}
    said = "\n".join(f"{key}: {', '.join(values)}" for key, values in notes.items() if values)
    text = f'"""{mistake}\n\n{said}\n"""\n' + "".join(f"{line}\n" for line in lines)
    try:
        _require_syntax(text)
    except SyntaxError as error:
        shown = (error.text or "").strip()
        raise InputError(f"{where}: renders to no Python: {error.msg}: {shown!r}") from None
    checks, modules = frozenset(entry.fails), frozenset(entry.requires)
    return Mutant(name, mistake, checks, modules, base.file, text, entry.why)


@cache
def _require_syntax(text: str) -> None:
    """Parse once what is rendered again and again."""
    ast.parse(text)
