"""Read cells without running them: which file a cell writes, which checks it asks for."""

import ast
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from grader.course.exercises import find_exercise
from grader.errors import InputError
from grader.nbgrader.intake import MAX_SOURCE

MAGIC = re.compile(r"%%(node|writefile|file)[ \t]+(\S.*)")  # IPython's own write files, too
MORE = ("-a", "--append")  # options of IPython's
MODULE = re.compile(r"(?:[A-Za-z_]\w{0,99}/){0,3}[A-Za-z_]\w{0,99}\.py", re.ASCII)
BOM = "\ufeff"
QUOTES = "'\""


@dataclass(frozen=True)
class Definition:
    """A cell that writes a file."""

    file: str
    text: str
    more: bool = False  # the text goes on where that of the cell before it ends


@dataclass(frozen=True)
class Wanted:
    """The checks of one exercise that a test cell asks for."""

    exercise: str  # slug
    checks: tuple[str, ...]  # (): all that give points


def definition(source: str) -> Definition | None:
    """Return the file that a cell writes with `%%node FILE`, or with IPython's `%%writefile FILE`.

    None if it writes none. This accepts more than a kernel does: blank lines, comments and other
    magics may come first. The text is what the kernel would write: all lines below the magic, with
    a newline at the end.
    """
    lines = source.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line in enumerate(lines):
        said = line.replace(BOM, "").strip()
        if found := MAGIC.fullmatch(said):
            indent = line[: len(line) - len(line.lstrip())].replace(BOM, "")
            below = "\n".join(below.removeprefix(indent) for below in lines[number + 1 :])
            text = below if below.endswith("\n") or not below else f"{below}\n"
            if found[1] == "node":
                return Definition(found[2].strip(QUOTES), text)
            words = [word for word in found[2].split() if word not in MORE]
            place = PurePosixPath(" ".join(words).strip(QUOTES))
            file = place.name if place.is_absolute() else str(place)  # /content/agent.py: Colab
            return Definition(file, text, len(words) < len(found[2].split()))
        if said and not said.startswith(("#", "%")):
            return None
    return None


def last_definitions(
    cells: Iterable[tuple[str, str]], names: Sequence[str]
) -> tuple[dict[str, str], list[str]]:
    """Return the texts of the files called `names`, and remarks about which cells were used.

    Parameters
    ----------
    cells
        Type ("code", "markdown", "raw") and source of each cell, in order. The last code cell that
        writes a file counts. If no code cell writes it, other cells count: a cell's type is easily
        changed by accident.
    names
        The files to find.
    """
    found: dict[str, list[tuple[int, str]]] = {}
    outside: dict[str, tuple[int, str]] = {}
    for number, (kind, source) in enumerate(cells, start=1):
        made = definition(source)
        if made is None or made.file not in names:
            continue
        if kind == "code":
            before, text = found.setdefault(made.file, []), made.text
            if made.more and before:
                text = (before.pop()[1] + text)[:MAX_SOURCE]
            before.append((number, text))
        else:
            outside[made.file] = number, made.text
    texts, remarks = {}, []
    for name in names:
        if places := found.get(name):
            number, texts[name] = places[-1]
            if len({text for _, text in places}) > 1:
                remarks.append(
                    f"{len(places)} cells write {name}; the last, cell {number}, counts."
                )
        elif name in outside:
            number, texts[name] = outside[name]
            remarks.append(f"Cell {number} writes {name} but is no code cell; it was used as one.")
    return texts, remarks


def wanted(source: str) -> Wanted | None:
    """Return the checks that a test cell asks for with `check("exercise:check,check")`.

    None if it is not such a cell.

    Raises InputError: there is no such exercise.
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
    """Return the names of the files that the cells write, for a message: at most five."""
    made = [definition(source) for _, source in cells]
    return list(dict.fromkeys(one.file[:60] for one in made if one is not None))[:5]


def modules(cells: Iterable[tuple[str, str]]) -> list[str]:
    """Return the names of the files that the cells write and that can lie beside a node."""
    made = [definition(source) for _, source in cells]
    return list(dict.fromkeys(one.file for one in made if one and MODULE.fullmatch(one.file)))


def unknown_checks(asked: Wanted, known: Iterable[str]) -> None:
    """Make sure that the exercise has these checks.

    Raises InputError: it lacks one.
    """
    for check in asked.checks:
        if check not in known:
            raise InputError(f"unknown check {check!r} of {asked.exercise}")
