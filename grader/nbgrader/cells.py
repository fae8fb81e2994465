"""Read what cells say without running them: which file they make, which checks they ask for."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from grader.course.exercises import find_exercise
from grader.errors import InputError

MAGIC = re.compile(r"%%node[ \t]+(\S.*)")
BOM = "\ufeff"
QUOTES = "'\""


@dataclass(frozen=True)
class Definition:
    """A cell that makes a file."""

    file: str
    text: str


@dataclass(frozen=True)
class Wanted:
    """What a test cell asks for: checks of one exercise."""

    exercise: str  # slug
    checks: tuple[str, ...]  # none: all that give points


def definition(source: str) -> Definition | None:
    """Return the file that a cell makes with `%%node FILE`; None if it makes none.

    More is taken than a kernel would: blank lines, comments and other magics may stand above. The
    text is what the kernel would write: all below the magic, with a newline at its end.
    """
    lines = source.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line in enumerate(lines):
        said = line.replace(BOM, "").strip()
        if found := MAGIC.fullmatch(said):
            indent = line[: len(line) - len(line.lstrip())].replace(BOM, "")
            below = "\n".join(below.removeprefix(indent) for below in lines[number + 1 :])
            text = below if below.endswith("\n") or not below else f"{below}\n"
            return Definition(found[1].strip(QUOTES), text)
        if said and not said.startswith(("#", "%")):
            return None
    return None


def last_definitions(
    cells: Iterable[tuple[str, str]], names: Sequence[str]
) -> tuple[dict[str, str], list[str]]:
    """Return the texts of the files called `names`, and remarks about what was taken.

    Parameters
    ----------
    cells
        Type ("code", "markdown", "raw") and source of each cell, in order. The last code cell that
        makes a file counts. Others count where no code cell makes it: a cell's type is easily
        changed by a slip of the hand.
    names
        The files that are looked for.
    """
    found: dict[str, list[tuple[int, str]]] = {}
    outside: dict[str, tuple[int, str]] = {}
    for number, (kind, source) in enumerate(cells, start=1):
        made = definition(source)
        if made is None or made.file not in names:
            continue
        if kind == "code":
            found.setdefault(made.file, []).append((number, made.text))
        else:
            outside[made.file] = number, made.text
    texts, remarks = {}, []
    for name in names:
        if places := found.get(name):
            number, texts[name] = places[-1]
            if len({text for _, text in places}) > 1:
                remarks.append(f"{len(places)} cells make {name}; the last, cell {number}, counts.")
        elif name in outside:
            number, texts[name] = outside[name]
            remarks.append(f"Cell {number} makes {name} but is no code cell; it was taken as one.")
    return texts, remarks


def wanted(source: str) -> Wanted | None:
    """Return the checks for which a test cell asks with `check("exercise:check,check")`.

    None if it is no such cell.

    Raises
    ------
    InputError
        There is no such exercise.
    """
    try:
        body = ast.parse(source).body
    except (SyntaxError, ValueError):
        return None
    match body:
        case [ast.Expr(ast.Call(ast.Name("check"), [ast.Constant(str(name))], []))]:
            exercise, _, checks = name.partition(":")
            ids = tuple(part.strip() for part in checks.split(",") if part.strip())
            return Wanted(find_exercise(exercise.strip()).slug, ids)
    return None


def made_files(cells: Iterable[tuple[str, str]]) -> list[str]:
    """Return the names of all files that the cells make, for a message: at most five."""
    made = [definition(source) for _, source in cells]
    return list(dict.fromkeys(one.file[:60] for one in made if one is not None))[:5]


def unknown_checks(asked: Wanted, known: Iterable[str]) -> None:
    """Refuse checks that the exercise doesn't have.

    Raises
    ------
    InputError
        One is unknown.
    """
    for check in asked.checks:
        if check not in known:
            raise InputError(f"unknown check {check!r} of {asked.exercise}")
