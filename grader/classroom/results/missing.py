"""Parts of the results that could not be made: each is named, and the others are written."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from grader.classroom.results.clean import one_line
from grader.errors import is_disk_full

MOST_WHY = 200  # [characters]

T = TypeVar("T")


@dataclass(frozen=True)
class Missing:
    """A part that could not be made."""

    part: str  # for a sentence, such as "scores.csv"
    why: str

    def __str__(self) -> str:
        """Return the line of the terminal and the class report."""
        return f"{self.part}: {self.why}"


class Parts:
    """Makes the parts of the results one by one: what fails costs only itself."""

    def __init__(self) -> None:
        self.missing: list[Missing] = []

    @contextlib.contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Note that the part is missing if the block fails.

        A full disk passes: what comes next would fail, too.
        """
        try:
            yield
        except Exception as error:
            if is_disk_full(error):
                raise
            self.missing.append(Missing(one_line(name), why(error)))

    def made(self, name: str, make: Callable[[], T], otherwise: Callable[[Missing], T]) -> T:
        """Return what `make` returns; `otherwise`, told what is missing, if it fails."""
        with self.part(name):
            return make()
        return otherwise(self.missing[-1])


def why(error: BaseException) -> str:
    """Say in one line what an error was."""
    kind = type(error).__name__
    try:
        text = one_line(str(error), MOST_WHY)
    except Exception:
        text = ""
    return f"{kind}: {text}" if text else kind
