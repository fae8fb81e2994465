"""Read a submitted notebook, whatever it holds and as what it was saved, into plain cells.

Only a cell's type, text, nbgrader id and pasted pictures are kept; outputs and all other metadata
are dropped.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import IO, Any

from grader.course.submission import MAX_SIZE
from grader.nbgrader.exported import SUFFIX, cells_written
from rclpy_virtual_time import FileReader

MAX_NOTEBOOK = 50 * 1024 * 1024  # [bytes], pictures and outputs included
MAX_CELLS = 1_000
MAX_NESTED = 500_000  # of brackets that open: each becomes an object, 50 times as large as its text
MAX_QUOTES = 4_000_000
MAX_SOURCE = 2 * MAX_SIZE  # [characters] of a cell; above MAX_SIZE, which the judge refuses
MAX_PICTURES = 8 * 1024 * 1024  # [characters] of one cell
NO_CELL = (
    "it is a notebook saved as a program, and in none of its cells a file can be told; expected "
    "the notebook itself (.ipynb), or the file that its %%node cell wrote"
)
KINDS = ("code", "markdown", "raw")
PICTURES = ("image/png", "image/jpeg", "image/gif")


@dataclass(frozen=True)
class Cell:
    """A cell as a student wrote it."""

    kind: str  # "code", "markdown" or "raw"
    source: str
    grade_id: str = ""  # from its metadata; "" if there is none
    pictures: Mapping[str, Mapping[str, str]] = field(default_factory=dict)  # name: type: base64


def read_cells(path: Path) -> list[Cell]:
    """Return the cells of a notebook, which another process parses; none of another program.

    Raises FileReader.Refused: it is not a notebook, is too large, or is not an ordinary file.
    """
    try:
        return FileReader(answer=64 << 20).read(
            cells_in, MAX_NOTEBOOK, path.suffix.lower() == SUFFIX, file=path, returns=list[Cell]
        )
    except OSError as error:
        raise FileReader.Refused(f"the file cannot be read ({error.strerror})") from None


def cells_in(file: IO[bytes], most: int = MAX_NOTEBOOK, sure: bool = True) -> list[Cell]:
    """Return the cells of a notebook of at most `most` bytes, in this process.

    Of one that was saved as a program they are those that write files; none of a program that is no
    notebook, unless the caller is `sure` that it is one.

    Raises FileReader.Refused: it is not a notebook, or is too large.
    """
    data = file.read(most + 1)
    if len(data) > most:
        raise FileReader.Refused(f"the file is larger than {most:,} bytes; clear its outputs")
    if data.count(b"{") + data.count(b"[") > MAX_NESTED or data.count(b'"') > MAX_QUOTES:
        raise FileReader.Refused("it has far more parts than any notebook; clear its outputs")
    try:
        text = data.decode("utf-8-sig", "replace")
        del data
        if not text.lstrip().startswith("{"):
            if (saved := cells_written(text)) == []:
                raise FileReader.Refused(NO_CELL)
            if saved is not None or not sure:
                return [Cell("code", source[:MAX_SOURCE]) for source in (saved or ())[:MAX_CELLS]]
        notebook = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileReader.Refused(f"it is not JSON ({_short(error)})") from None
    cells = list(islice(_cells(notebook), MAX_CELLS))
    if not cells:
        raise FileReader.Refused("it is not a notebook, or it has no cells")
    return cells


def _cells(notebook: Any) -> Iterator[Cell]:
    if not isinstance(notebook, dict):
        return
    sheets = notebook.get("worksheets")  # of notebooks older than format 4
    sheets = sheets if isinstance(sheets, list) else []
    for part in (notebook, *sheets):
        found = part.get("cells") if isinstance(part, dict) else None
        for cell in found if isinstance(found, list) else []:
            if isinstance(cell, dict):
                yield _cell(cell)


def _cell(cell: dict[str, Any]) -> Cell:
    kind = cell.get("cell_type")
    source = _text(cell.get("source", cell.get("input")))
    return Cell(
        kind if kind in KINDS else "raw",
        source[:MAX_SOURCE],
        _grade_id(cell.get("metadata")),
        _pictures(cell.get("attachments")),
    )


def _text(source: Any) -> str:
    if isinstance(source, list):
        source = "".join(line for line in source if isinstance(line, str))
    if not isinstance(source, str):
        return ""
    return source.encode("utf-8", "replace").decode("utf-8")  # no lone surrogates


def _grade_id(metadata: Any) -> str:
    about = metadata.get("nbgrader") if isinstance(metadata, dict) else None
    name = about.get("grade_id") if isinstance(about, dict) else None
    return name if isinstance(name, str) else ""


def _pictures(attachments: Any) -> dict[str, dict[str, str]]:
    """Return pasted pictures: base64 text of harmless types."""
    kept: dict[str, dict[str, str]] = {}
    for name, forms in attachments.items() if isinstance(attachments, dict) else ():
        for mime, data in forms.items() if isinstance(forms, dict) else ():
            text = _text(data)
            plain = text.replace("\n", "").isascii() and not set(text) & set("\"'<>")
            if mime in PICTURES and plain and len(text) <= MAX_PICTURES:
                kept.setdefault(str(name), {})[mime] = text
    return kept


def _short(error: BaseException) -> str:
    return (str(error) or type(error).__name__)[:120]
