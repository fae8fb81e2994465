"""The nodes in a notebook: what its `%%node` cells write is a student's work like any file."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from grader.classroom.intake.skeletons import bare, skeletons
from grader.nbgrader.cells import last_definitions, modules
from grader.nbgrader.exported import SUFFIX
from grader.nbgrader.intake import cells_in
from rclpy_virtual_time import FileReader

PLAIN = re.compile(r"cell_\d+\.py")
NODE = re.compile(r"^(?:import|from) rclpy\b.*^class \w+\(.*^def main\b", re.DOTALL | re.MULTILINE)


def node_files(notebook: Path, room: Path) -> tuple[list[Path], list[str]] | None:
    """Write the exercises' files that a notebook's cells define into `room`; return these, remarks.

    Modules that other cells write come along with them.
    Of several cells for one file the last counts, as for nbgrader. What is still the skeleton was
    not worked on, and is no file. Where no cell says what it writes, each that looks like a node
    is a file `cell_7.py`. None for a program that is no notebook.

    Raises FileReader.Refused: it is no notebook.
    """
    known = skeletons()
    try:
        found = FileReader(answer=64 << 20).read(
            texts_in, list(known), notebook.suffix.lower() == SUFFIX, file=notebook,
            returns=tuple[dict[str, str], list[str]] | None,
        )  # fmt: skip
    except OSError as error:
        raise FileReader.Refused(f"the file cannot be read ({error.strerror})") from None
    if found is None:
        return None
    texts, remarks = found
    plain = [name for name in texts if PLAIN.fullmatch(name)]
    worked = [name for name, text in texts.items() if bare(text) != known.get(name)]
    made = []
    for name in worked if plain or any(name in known for name in worked) else ():
        made.append(room / name)
        made[-1].parent.mkdir(parents=True, exist_ok=True)
        made[-1].write_text(texts[name], "utf-8")
    return made, remarks


def texts_in(
    notebook: IO[bytes], names: Sequence[str], sure: bool
) -> tuple[dict[str, str], list[str]] | None:
    """Return texts of files called `names`, and of modules, that a notebook's cells write; remarks.

    None for a program that is no notebook; who is `sure` that it is one is told what is wrong.

    Raises FileReader.Refused: it is no notebook.
    """
    cells = [(cell.kind, cell.source) for cell in cells_in(notebook, sure=sure)]
    if not cells:
        return None
    texts, remarks = last_definitions(cells, list(dict.fromkeys((*names, *modules(cells)))))
    if not set(names).isdisjoint(texts):
        return texts, remarks
    code = {f"cell_{number}.py": text for number, (kind, text) in enumerate(cells, 1)
            if kind == "code" and not text.lstrip().startswith("%%")}  # fmt: skip
    return texts | {name: text for name, text in code.items() if NODE.search(text)}, remarks
