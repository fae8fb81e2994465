"""The lesson's numbers, read from contract.toml: one place for pages and tests."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).with_name("contract.toml")
NO_BREAK = "\N{NO-BREAK SPACE}"


@dataclass(frozen=True)
class Number:
    """A number that pages and figures show."""

    key: str
    value: float  # an int stays one: it is shown as it is written
    unit: str = ""
    law: str = ""  # where the course defines it, or how it follows from other numbers
    own: str = ""  # why it is the lesson's own instead
    scale: float = 1.0  # what the law's value is multiplied by: 1000 for s to ms
    about: float = 0.0  # by how much it may differ from its law: rounding

    @property
    def text(self) -> str:
        """Value and unit as a reader sees them."""
        space = "" if self.unit in ("", "°") else NO_BREAK
        return f"{self.value}{space}{self.unit}"


def read(file: Path = FILE) -> dict[str, Number]:
    """Return every number by its key.

    Raises TypeError: an entry has a key that a Number does not have, or lacks one.
    """
    tables = tomllib.loads(file.read_text("utf-8"))
    return {key: Number(key=key, **entry) for key, entry in tables.items()}
