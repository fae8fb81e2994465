"""What an instructor decides about the results: title, remarks, and what students don't see."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field

from grader.errors import InputError

HIDE = {
    "nothing": "students see all that the grader saw",
    "field": "no field checks and none of their runs",
    "worlds": "no seeds and no replays, so that hidden worlds stay hidden",
    "details": "the same, and of a failed check only its title and where to look next",
}

Sources = Mapping[tuple[str, str], Mapping[str, bytes]]


@dataclass(frozen=True)
class ResultOptions:
    """How results are written."""

    hide: str = "nothing"  # one of HIDE, or several with commas: "field,worlds"
    title: str = "Bridging Python agents with rclpy"  # of the course
    notes: list[str] = field(default_factory=list)  # the batch's own remarks, a sentence each
    # (student, exercise): file name → text; without them no similar submissions are looked for
    sources: Sources = field(default_factory=dict)
    replays: bool = True  # put replays into the feedback pages (where there are recordings)
    workers: int = 1  # processes that make the feedback pages

    def __post_init__(self) -> None:
        """Refuse what nobody can hide.

        Raises
        ------
        InputError
            `hide` has an unknown word.
        """
        for word in self.hidden:
            if word not in HIDE:
                near = difflib.get_close_matches(word, HIDE, n=1)
                hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(HIDE)}"
                raise InputError(f"hide: unknown word {word!r}; {hint}")

    @property
    def hidden(self) -> frozenset[str]:
        """The words of `hide`."""
        return frozenset(word.strip() for word in self.hide.split(",") if word.strip())
