"""CSV for gradebooks and spreadsheets (RFC 4180): text is made harmless, ids stay as they are."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from grader.lms.clean import cell


class Verbatim(str):
    """Text that a gradebook has to find again: an id, a heading, a time. It is not changed."""

    __slots__ = ()


Cell = str | float | int | None


def csv_text(rows: Iterable[Sequence[Cell]]) -> str:
    """Return a table as CSV."""
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
