"""The nodes in a notebook: what its `%%node` cells write is a student's work like any file."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import IO

from grader.course.exercises import all_exercises
from grader.link.cell import MIB, Limits, Refused, read_in_cell
from grader.nbgrader.cells import last_definitions, modules
from grader.nbgrader.intake import cells_in

SUFFIX = ".ipynb"


def node_files(notebook: Path, room: Path) -> list[Path]:
    """Write the exercises' files that a notebook's cells define into `room`; return them.

    Modules that other cells write come along with them.
    Of several cells for one file the last counts, as for nbgrader. What is still the skeleton was
    not worked on, and is no file.

    Raises Refused: it is no notebook.
    """
    skeletons = _skeletons()
    try:
        texts = read_in_cell(
            texts_in, list(skeletons), file=notebook, returns=dict[str, str],
            limits=Limits(answer=64 * MIB),
        )  # fmt: skip
    except OSError as error:
        raise Refused(f"the file cannot be read ({error.strerror})") from None
    worked = [name for name, text in texts.items() if _bare(text) != skeletons.get(name)]
    made = []
    for name in worked if any(name in skeletons for name in worked) else ():
        room.mkdir(parents=True, exist_ok=True)
        made.append(room / name)
        made[-1].write_text(texts[name], "utf-8")
    return made


def texts_in(notebook: IO[bytes], names: Sequence[str]) -> dict[str, str]:
    """Return the texts of the files called `names`, and of modules, that a notebook's cells write.

    Raises Refused: it is no notebook.
    """
    cells = [(cell.kind, cell.source) for cell in cells_in(notebook)]
    texts, _ = last_definitions(cells, list(dict.fromkeys((*names, *modules(cells)))))
    return texts


@cache
def _skeletons() -> dict[str, str]:
    """Return the text of each exercise's file as students get it."""
    return {
        name: _bare((exercise.folder / name).read_text("utf-8"))
        for exercise in all_exercises()
        for name in exercise.files
        if (exercise.folder / name).is_file()
    }


def _bare(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip().splitlines())
