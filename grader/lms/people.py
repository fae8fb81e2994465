"""People of a roster, and how they are found by what a download calls them."""

import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from grader.lms.names import numbered

# Kinds of ids. The first that a person has is what makes them who they are.
CANVAS, SIS, LOGIN, EMAIL, NUMBER, GITHUB, OWN = (
    "canvas", "sis", "login", "email", "idnumber", "github", "id",
)  # fmt: skip
# What is one assignment's, so that a person has several: Moodle's participant, GitHub's repository
PARTICIPANT = "participant"
STRONG = (CANVAS, SIS, LOGIN, EMAIL, NUMBER, GITHUB, OWN)
LISTED = (CANVAS, OWN, NUMBER, SIS, LOGIN, EMAIL, GITHUB)  # as instructors' lists likely have them


@dataclass(frozen=True)
class Person:
    """One who is in the class."""

    name: str  # as the sheet writes it: "Lee, Carla"
    section: str = ""
    ids: Mapping[str, str] = field(default_factory=dict)  # kind: id
    participants: frozenset[str] = frozenset()
    group: str = ""  # with which they hand in

    @property
    def key(self) -> str:
        """What tells this person from all others."""
        kind = next((kind for kind in in_order(self.ids) if self.ids[kind]), "")
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
class Match:
    """Whom an entry of a download means."""

    people: tuple[Person, ...] = ()  # one, or all of a group
    may_be: tuple[Person, ...] = ()  # if it can't be told
    sure: bool = False  # by an id; not by a name alone


@dataclass(frozen=True)
class Sheet:
    """A file that a roster was read from, as it came."""

    file: Path
    kind: str  # "canvas", "moodle", "worksheet", "gradescope", "github", "csv"
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]  # as long as the header
    people: tuple[int, ...]  # of each row: its place in the roster
    points: Mapping[str, str] = field(default_factory=dict)  # Canvas's "Points Possible"
    english: tuple[str, ...] = ()  # the headings that Moodle has in English; (): they are

    @property
    def small(self) -> list[str]:
        """The headings in English and small letters."""
        return [heading.casefold() for heading in self.english or self.header]

    def cell(self, row: Sequence[str] | None, heading: str) -> str:
        """Return what a row has below a heading in small letters; "" if there is none."""
        return row[self.small.index(heading)].strip() if row and heading in self.small else ""


@dataclass(frozen=True)
class Roster:
    """Everybody in the class."""

    people: tuple[Person, ...] = ()
    sheets: tuple[Sheet, ...] = ()

    def is_from(self, path: Path) -> bool:
        return any(path.exists() and path.samefile(sheet.file) for sheet in self.sheets)

    @cached_property
    def _index(self) -> Mapping[tuple[str, str], list[Person]]:
        """The people by kind of id or name, and what it is."""
        found: dict[tuple[str, str], list[Person]] = {}
        for person in self.people:
            words = [(kind, id_.casefold()) for kind, id_ in person.ids.items()]
            words += [(PARTICIPANT, participant) for participant in person.participants]
            words += [("name", name) for name in person.names]
            words += [("team", squeezed(person.group)), ("squeezed", squeezed(person.name))]
            for kind, word in words:
                if word:
                    found.setdefault((kind, word), []).append(person)
        return found

    @cached_property
    def kinds(self) -> list[str]:
        """The kinds of the people's ids."""
        return in_order({kind for person in self.people for kind in person.ids})

    def one(self, kind: str, word: str) -> Person | None:
        """Return the person whom an id or a name means; None if it fits nobody or several."""
        found = self.every(kind, word)
        return found[0] if len(found) == 1 else None

    def by_word(self, *words: str) -> Person | None:
        """Return the person whom the first word means that is an id of any kind."""
        found = (self.one(kind, word) for word in filter(None, words) for kind in self.kinds)
        return next((person for person in found if person is not None), None)

    def every(self, kind: str, word: str) -> tuple[Person, ...]:
        return tuple(self._index.get((kind, word.casefold()), ()))

    def team(self, name: str, form: Callable[[str], str]) -> tuple[Person, ...]:
        """Return everybody in the group of that name, written in this form."""
        found = self.every("team", squeezed(name))
        return tuple(person for person in found if form(person.group) == form(name))

    def like(self, name: str, id_: str, team: tuple[Person, ...]) -> tuple[Person, ...]:
        """Return the people of that name or id, where neither is what counts, and the group."""
        found = [*self.every("name", folded(name)), *self.every("squeezed", squeezed(name))]
        found += [person for kind in self.kinds for person in self.every(kind, id_) if id_]
        found += self.every(GITHUB, numbered(id_)[0])
        return each_once((*found, *team))


def in_order(kinds: Iterable[str], first: Sequence[str] = STRONG) -> list[str]:
    """Return kinds of ids in the order in which they count; a platform may have one of its own."""
    return sorted(
        kinds, key=lambda kind: (first.index(kind) if kind in first else len(first), kind)
    )


def only(found: tuple[Person, ...]) -> Match:
    """Return who is meant if it is one; none is guessed of several."""
    return Match(found) if len(found) == 1 else Match((), found)


def each_once(people: Iterable[Person]) -> tuple[Person, ...]:
    return tuple({person.key: person for person in people}.values())


def trailing(identifier: str) -> str:
    """Return the number at the end of "Participant 4711", which is in the platform's language."""
    match = re.search(r"\d+$", identifier.strip())
    return match[0] if match else ""


# double ones, too: Moodle's names of files have none of them
APOSTROPHES = dict.fromkeys(map(ord, "'\u2019\u2018\u02bc\u0060\u00b4\"\u201c\u201d"))


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
