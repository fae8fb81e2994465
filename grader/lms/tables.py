"""What platforms take back: CSV (RFC 4180), with text made harmless and ids as they are; zips."""

import csv
import io
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import BinaryIO

from grader.lms.clean import cell

EPOCH = (1980, 1, 1, 0, 0, 0)


class Verbatim(str):
    """Text that a gradebook has to find again: an id, a heading, a time. It is not changed."""

    __slots__ = ()


Cell = str | float | int | None


def csv_text(rows: Iterable[Sequence[Cell]]) -> str:
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\r\n")
    for row in rows:
        writer.writerow([_written(value) for value in row])
    return target.getvalue()


def number(value: float) -> str:
    """Return points as gradebooks write them: at most two decimals, no exponent."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def _written(value: Cell) -> str:
    if value is None:
        return ""
    if isinstance(value, Verbatim):
        return value
    return cell(value) if isinstance(value, str) else number(value)


def pack(target: BinaryIO, pages: Iterable[tuple[str, Path]]) -> None:
    """Write a zip with these files, each under its name, as far as they are there.

    The same pages make the same bytes.
    """
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, page in pages:
            if page.is_file():
                info = zipfile.ZipInfo(name, EPOCH)
                info.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(info, page.read_bytes())
