"""People of a roster, and how they are found by what a download calls them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

# Kinds of ids. The first that a person has is what makes them who they are.
CANVAS, SIS, LOGIN, EMAIL, NUMBER, GITHUB, OWN = (
    "canvas", "sis", "login", "email", "idnumber", "github", "id",
)  # fmt: skip
PARTICIPANT = "participant"  # Moodle's, of one assignment: a person has several
STRONG = (CANVAS, SIS, LOGIN, EMAIL, NUMBER, GITHUB, OWN)


@dataclass(frozen=True)
class Person:
    """One who is in the class."""

    name: str  # as the sheet writes it: "Lee, Carla"
    section: str = ""
    ids: Mapping[str, str] = field(default_factory=dict)  # kind: id
    participants: frozenset[str] = frozenset()

    @property
    def key(self) -> str:
        """What tells this person from all others."""
        kind = next((kind for kind in STRONG if self.ids.get(kind)), "")
        if kind:
            return f"{kind}:{self.ids[kind]}"
        return f"{PARTICIPANT}:{min(self.participants)}" if self.participants else self.name

    @property
    def label(self) -> str:
        """The name for people, first name first."""
        last, comma, first = self.name.partition(",")
        return f"{first.strip()} {last.strip()}" if comma and first.strip() else self.name

    @property
    def names(self) -> frozenset[str]:
        """The forms of the name that a download may have, for comparison."""
        return frozenset({folded(self.name), folded(self.label)}) - {""}


@dataclass(frozen=True)
class Sheet:
    """A file that a roster was read from, as it came."""

    file: Path
    kind: str  # "canvas", "moodle", "worksheet", "gradescope", "github", "csv"
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]  # as long as the header
    people: tuple[int, ...]  # of each row: its place in the roster
    points: Mapping[str, str] = field(default_factory=dict)  # Canvas's "Points Possible"

    @property
    def small(self) -> list[str]:
        """The headings in small letters."""
        return [heading.casefold() for heading in self.header]

    def cell(self, row: Sequence[str] | None, heading: str) -> str:
        """Return what a row has below a heading in small letters; "" if there is none."""
        return row[self.small.index(heading)].strip() if row and heading in self.small else ""


@dataclass(frozen=True)
class Roster:
    """Everybody in the class."""

    people: tuple[Person, ...] = ()
    sheets: tuple[Sheet, ...] = ()

    def is_from(self, path: Path) -> bool:
        """Return whether the roster was read from this file."""
        return any(path.exists() and path.samefile(sheet.file) for sheet in self.sheets)

    def find(self, system: str, name: str, id_: str = "", email: str = "") -> Person | None:
        """Return the person a download means; None if nobody or more than one can be meant.

        The platform's own key counts alone where the roster has it: students choose their names,
        on GitHub their logins, and on Gradescope they type their number. Else ids, then names.
        """
        kind, key = {
            "canvas": (CANVAS, id_), "github": (GITHUB, id_), "gradescope": (EMAIL, email)
        }.get(system, ("", ""))  # fmt: skip
        if key and any(person.ids.get(kind) for person in self.people):
            return self._one(kind, key)
        named = self._one("name", folded(name))
        if system == "moodle" and id_ and (found := self._one(PARTICIPANT, id_)) is not None:
            same = folded(found.name) == folded(name) or name.casefold() == "participant"
            return found if same or named is None else None  # renamed like another: who is it?
        words = [id_, email] if system in ("gradescope", "nbgrader", "github") else []
        words += [name] if system in ("folder", "nbgrader", "github") else []
        for word in filter(None, words):
            for kind in STRONG:
                if (found := self._one(kind, word)) is not None:
                    return found
        if system == "canvas":
            return self._one("squeezed", squeezed(name))
        return named or (self._in_group(name) if system == "moodle" else None)

    def why_not(self, name: str) -> str:
        """Say why `find` found nobody."""
        called = [person for person in self.people if folded(name) in person.names]
        if len(called) > 1:
            return (
                f"{len(called)} people of the roster are called so; with Moodle, give the "
                "assignment's grading worksheet as another --roster: it has the identifiers"
            )
        return "nobody in the roster is called so or has this id"

    @cached_property
    def _index(self) -> Mapping[tuple[str, str], list[Person]]:
        """The people by kind of id or name, and what it is."""
        found: dict[tuple[str, str], list[Person]] = {}
        for person in self.people:
            words = [(kind, id_.casefold()) for kind, id_ in person.ids.items()]
            words += [(PARTICIPANT, participant) for participant in person.participants]
            words += [("name", name) for name in person.names]
            for kind, word in [*words, ("squeezed", squeezed(person.name))]:
                if word:
                    found.setdefault((kind, word), []).append(person)
        return found

    def _one(self, kind: str, word: str) -> Person | None:
        """Return the person whom an id or a name means; None if it fits nobody or several."""
        found = self._index.get((kind, word.casefold()), [])
        return found[0] if len(found) == 1 else None

    def _in_group(self, name: str) -> Person | None:
        """Find somebody by `GROUP-NAME`, as Moodle calls them where students work in groups."""
        parts = name.split("-")
        found = [self._one("name", folded("-".join(parts[i:]))) for i in range(1, len(parts))]
        people = {person.key: person for person in found if person is not None}
        return next(iter(people.values())) if len(people) == 1 else None


APOSTROPHES = dict.fromkeys(map(ord, "'\u2019\u2018\u02bc\u0060\u00b4"))


def folded(name: str) -> str:
    """Return a name for comparison: NFC, no capitals, single spaces, no underscores.

    Apostrophes are left out, as Moodle does in the names of files.
    """
    text = unicodedata.normalize("NFC", name).replace("_", " ").casefold()
    return " ".join(text.translate(APOSTROPHES).split())


def squeezed(name: str) -> str:
    """Return a sortable name as Canvas puts it in front of a file: only word characters."""
    return re.sub(r"[\W_]", "", unicodedata.normalize("NFC", name).casefold())


def unquoted(name: str) -> str:
    """Return a name that begins with "=" without what Canvas puts around it."""
    match = re.fullmatch(r'="(.*)"', name, re.DOTALL)
    return match[1] if match else name


NOBODY = Roster()
NO_PERSON = Person("")  # one who is in no roster
