"""Small edits of a text, written as the hunks of a diff.

A line that begins with `-` goes, one with `+` comes, one with a space stays; `@@` on a line of its
own parts two hunks. Where a hunk belongs is found by its old lines, those that go or stay: they
must occur exactly once, or it is an error. So an edit that no longer fits never passes unseen.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from dataclasses import dataclass

SEPARATOR = "@@"


class EditError(ValueError):
    """Text that is no edit, or an edit that does not fit its text."""


@dataclass(frozen=True)
class _Hunk:
    old: list[str]
    new: list[str]
    head: str  # its first line, to name it in errors


def edited(lines: list[str], edit: str, name: str) -> list[str]:
    """Return a text's lines, edited.

    Raises EditError: a hunk does not fit in exactly one place, changes nothing, or is no hunk.

    Parameters
    ----------
    lines
        The text.
    edit
        The hunks, in any order.
    name
        The text's, for errors.
    """
    placed = [(_place(hunk, lines, name), hunk) for hunk in _hunks(edit)]
    result: list[str] = []
    end = 0
    for start, hunk in sorted(placed, key=lambda one: one[0]):
        if start < end:
            raise EditError(f"hunk {hunk.head!r} overlaps another")
        result += lines[end:start] + hunk.new
        end = start + len(hunk.old)
    return result + lines[end:]


def _hunks(edit: str) -> Iterator[_Hunk]:
    for part in re.split(rf"(?m)^{SEPARATOR}$", edit):
        lines = part.removeprefix("\n").splitlines()
        head = lines[0] if lines else ""
        for line in lines:
            if line and line[0] not in "-+ ":
                raise EditError(f"line {line!r} begins with none of '-', '+' and ' '")
        old = [line[1:] for line in lines if line[:1] != "+"]
        new = [line[1:] for line in lines if line[:1] != "-"]
        if not old:
            raise EditError(f"hunk {head!r} has no old line, so nobody knows where it belongs")
        if old == new:
            raise EditError(f"hunk {head!r} changes nothing")
        yield _Hunk(old, new, head)


def _place(hunk: _Hunk, lines: list[str], name: str) -> int:
    """Return the index of the one place where a hunk fits."""
    size = len(hunk.old)
    places = [i for i in range(len(lines)) if lines[i : i + size] == hunk.old]
    if len(places) == 1:
        return places[0]
    hint = "add a line beside it, to tell the places apart"
    if not places:
        strange = next((line for line in hunk.old if line not in lines), None)
        if strange is None:
            n, i = max(
                (n, i) for n in range(1, size) for i in range(len(lines))
                if lines[i : i + n] == hunk.old[:n]
            )  # fmt: skip
            after = next(map(repr, lines[i + n :]), "nothing")
            hint = f"its lines are there, but behind {lines[i + n - 1]!r} stands {after}"
        else:
            near = difflib.get_close_matches(strange, lines, n=1, cutoff=0.0)[0]
            hint = f"the line nearest to {strange!r} is {near!r}"
    times = len(places)
    raise EditError(f"hunk {hunk.head!r} fits {times} times in {name}, expected once; {hint}")
