"""The survivors that a person has looked at: mutants that break nothing the contract asks for.

They are listed in `solutions/EXERCISE/equivalents.toml`, each with the reason in a sentence::

    [[equivalent]]
    mutants = ["* hears /scan OnlyNewer", "edit __init__: 10 → 11*"]  # as shells match names
    reason = "A subscription's depth is the student's choice."
"""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import translate
from re import compile as compile_pattern
from typing import Annotated

import msgspec

from grader.course.exercises import Exercise
from sim.toml_input import convert, parse_toml, read_toml

EQUIVALENTS = "equivalents.toml"
Text = Annotated[str, msgspec.Meta(min_length=1)]


class Equivalent(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Mutants that are as good as right, and why."""

    mutants: Annotated[tuple[Text, ...], msgspec.Meta(min_length=1)]  # patterns of names
    reason: Annotated[str, msgspec.Meta(min_length=20)]


class _List(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    equivalent: tuple[Equivalent, ...] = ()


@dataclass(frozen=True)
class Reviewed:
    """The list of one exercise."""

    entries: tuple[Equivalent, ...] = ()

    def reason(self, name: str) -> str:
        """Return why the mutant of this name is equivalent; empty if nobody says that it is."""
        for entry in self.entries:
            if any(_matches(pattern, name) for pattern in entry.mutants):
                return entry.reason
        return ""

    def unused(self, names: list[str]) -> list[str]:
        """Return the patterns that match none of these names."""
        patterns = (pattern for entry in self.entries for pattern in entry.mutants)
        return [p for p in patterns if not any(_matches(p, name) for name in names)]


def reviewed(exercise: Exercise) -> Reviewed:
    """Return the list of an exercise; empty if there is none.

    Raises
    ------
    InputError
        The file is broken.
    """
    path = exercise.solutions / EQUIVALENTS
    if not path.is_file():
        return Reviewed()
    doc = parse_toml(read_toml(path), str(path))
    return Reviewed(convert(doc, _List, str(path)).equivalent)


def _matches(pattern: str, name: str) -> bool:
    """Return whether a name fits a pattern in which only `*` and `?` mean something."""
    escaped = pattern.replace("[", "[[]")
    return compile_pattern(translate(escaped)).match(name) is not None
