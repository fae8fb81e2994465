"""Make the notebook that is graded: the student's cells, with nbgrader's own cells as released.

nbgrader recognises its cells by an id in their metadata, and students can do anything to these:
copy cells, delete, move or retype them, change ids and points. Here the gradebook decides which
cells exist and what they are worth; a student's edits of a test cell have no effect. Their text
stays as it is: the pages that show it sanitise it (`offline.py`).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from nbformat import NotebookNode, v4

from grader.nbgrader.cells import definition
from grader.nbgrader.intake import Cell

SCHEMA = 3  # of nbgrader's metadata
MAX_PROSE = 100_000  # [characters] of a cell that writes no file
MAX_ALL = 4_000_000  # [characters] of all cells that write no file
ABOUT = "course"  # key of our own metadata


@dataclass(frozen=True)
class Trusted:
    """A cell of nbgrader's, as the gradebook has it."""

    name: str  # its grade_id
    kind: str  # "code" or "markdown"
    source: str  # as released
    points: float | None = None  # None: gives none
    solution: bool = False  # the student writes here
    task: bool = False  # graded by hand; the student's work is in other cells

    @property
    def is_test(self) -> bool:
        """A test cell: it has points, and students write nothing into it."""
        return self.points is not None and not self.solution and not self.task

    @property
    def is_answer(self) -> bool:
        """An answer that a person grades."""
        return self.points is not None and self.solution

    def metadata(self) -> dict[str, Any]:
        """Return nbgrader's metadata for the cell."""
        points = {} if self.points is None else {"points": self.points}
        return {
            "schema_version": SCHEMA,
            "grade_id": self.name,
            "grade": self.points is not None and not self.task,
            "solution": self.solution,
            "locked": not self.solution,
            "task": self.task,
            "cell_type": self.kind,
            **points,
        }


def restored(cells: Sequence[Cell], trusted: Sequence[Trusted]) -> NotebookNode:
    """Return the notebook to grade."""
    places = _places(cells, trusted)
    budget = MAX_ALL
    made = []
    for number, cell in enumerate(cells):
        if (known := places.get(number)) is not None:
            made.append(_known(known, cell, number))
            continue
        budget -= 0 if definition(cell.source) else len(cell.source)
        made.append(_plain(cell, number, left_out=budget < 0))
    there = {known.name for known in places.values()}
    made += [_missing(known) for known in trusted if known.name not in there]
    return v4.new_notebook(cells=made)


def unreadable(problem: str, trusted: Sequence[Trusted]) -> NotebookNode:
    """Return a notebook that gives the problem, with nbgrader's cells for a person to mark."""
    note = v4.new_markdown_cell(f"The submitted notebook could not be read: {problem}.")
    note["id"] = "unreadable"
    made = v4.new_notebook(cells=[note, *(_missing(known) for known in trusted)])
    made.metadata[ABOUT] = {"problem": problem}
    return made


def _places(cells: Sequence[Cell], trusted: Sequence[Trusted]) -> dict[int, Trusted]:
    """Return which of the student's cells is which of nbgrader's, by the cell's number.

    Of several copies the last one counts; where students write, the last one that was edited.
    """
    places = {}
    for known in trusted:
        same = [number for number, cell in enumerate(cells) if cell.grade_id == known.name]
        changed = [n for n in same if cells[n].source.strip() != known.source.strip()]
        if known.solution and not known.is_answer:
            changed = [n for n in changed if definition(cells[n].source)]
        if chosen := (changed if known.solution and changed else same)[-1:]:
            places[chosen[0]] = known
    return places


def _known(known: Trusted, cell: Cell, number: int) -> NotebookNode:
    source, was = known.source, known.kind
    if known.solution:
        source, was = cell.source, cell.kind
        if known.kind == "markdown":
            source = source[:MAX_PROSE]
    made = _new(known.kind, source, f"cell-{number}", cell.pictures if known.is_answer else {})
    made.metadata["nbgrader"] = known.metadata()
    made.metadata[ABOUT] = {
        "was": was,
        "untouched": known.solution and cell.source.strip() == known.source.strip(),
    }
    return made


def _missing(known: Trusted) -> NotebookNode:
    source = "" if known.solution else known.source
    made = _new(known.kind, source, f"missing-{known.name}"[:64], {})
    made.metadata["nbgrader"] = known.metadata()
    made.metadata[ABOUT] = {"was": known.kind, "missing": True}
    return made


def _plain(cell: Cell, number: int, *, left_out: bool) -> NotebookNode:
    """Return a cell that nbgrader does not know; one that writes a file is kept as it is."""
    name = f"cell-{number}"
    if cell.kind == "code" or definition(cell.source):
        source = cell.source
        if not definition(source):
            source = "# left out: too long" if left_out else source[:MAX_PROSE]
        made = _new("code", source, name, {})
        made.metadata[ABOUT] = {"was": cell.kind}
        return made
    source = "(left out: too long)" if left_out else cell.source[:MAX_PROSE]
    return _new("markdown", source, name, cell.pictures)


def _new(
    kind: str, source: str, name: str, pictures: Mapping[str, Mapping[str, str]]
) -> NotebookNode:
    made = v4.new_code_cell(source) if kind == "code" else v4.new_markdown_cell(source)
    made["id"] = re.sub(r"[^A-Za-z0-9_-]", "-", name)
    if kind != "code" and pictures:
        made["attachments"] = {file: dict(forms) for file, forms in pictures.items()}
    return made
