"""People of a roster, and how they are found by what a download calls them."""

from __future__ import annotations

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

    def match(
        self, system: str, name: str, id_: str = "", email: str = "", place: str = ""
    ) -> Match:
        """Return whom a download means, by what it calls them, and the entry's own name.

        The platform's own key counts alone where the roster has it: students choose their names,
        on GitHub their logins, and on Gradescope they type their number. Else ids, then names.
        """
        if system == "moodle":
            return self._in_moodle(name, id_)
        if system == "github" and (team := self._all(PARTICIPANT, place)):
            return Match(team, sure=True)
        kind, key = {
            "canvas": (CANVAS, id_), "github": (GITHUB, id_), "gradescope": (EMAIL, email)
        }.get(system, ("", ""))  # fmt: skip
        if key and any(person.ids.get(kind) for person in self.people):
            found = self._one(kind, key)
            team = self._team(name, squeezed) if system != "gradescope" else ()
            if team and (found in team if system == "canvas" else found is None):
                own = found is not None and squeezed(found.name) == squeezed(name)
                return Match((), team) if own else Match(team, sure=True)
            return Match((found,), sure=True) if found else Match((), self._like(name, id_, team))
        words = [id_, email] if system in ("gradescope", "nbgrader", "github") else []
        words += [name] if system in ("folder", "nbgrader", "github") else []
        for word in filter(None, words):
            for kind in STRONG:
                if (found := self._one(kind, word)) is not None:
                    named = self._all("name", folded(name)) if system == "gradescope" else ()
                    if named and found not in named:  # a number that the student has typed
                        return Match((), _each_once((found, *named)))
                    return Match((found,), sure=True)
        if team := self._team(name, folded):
            return Match(team, sure=True)
        kind, form = ("squeezed", squeezed) if system == "canvas" else ("name", folded)
        return _only(self._all(kind, form(name)))

    def _in_moodle(self, name: str, id_: str) -> Match:
        """Return whom Moodle's prefix means: a participant, or a group whose number is its own."""
        holder = self._one(PARTICIPANT, id_) if id_ else None
        named, team = self._all("name", folded(name)), self._team(name, folded)
        forms = map(squeezed, (holder.name, holder.label)) if holder else ()
        in_group = self._in_group(name)
        if holder and (is_blind(name) or squeezed(name) in forms or in_group == holder):
            return Match((holder,), sure=True)
        if team:
            return Match((), (*named, *team)) if named else Match(team, sure=True)
        if holder:  # renamed, or a group's number: who is it?
            return Match((), _each_once((holder, *named)))
        return Match((in_group,)) if in_group and not named else _only(named)

    def participant(self, person: Person, group: str) -> str:
        """Return the number by which Moodle knows a member in a group's assignment."""
        for sheet in self.sheets:
            for row, place in zip(sheet.rows, sheet.people, strict=True):
                mine = self.people[place] == person and sheet.kind == "worksheet"
                if mine and folded(sheet.cell(row, "group")) == folded(group):
                    return trailing(sheet.cell(row, "identifier"))
        return min(person.participants, default="")

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

    def _one(self, kind: str, word: str) -> Person | None:
        """Return the person whom an id or a name means; None if it fits nobody or several."""
        found = self._all(kind, word)
        return found[0] if len(found) == 1 else None

    def _all(self, kind: str, word: str) -> tuple[Person, ...]:
        return tuple(self._index.get((kind, word.casefold()), ()))

    def _team(self, name: str, form: Callable[[str], str]) -> tuple[Person, ...]:
        """Return everybody in the group of that name, written in this form."""
        found = self._all("team", squeezed(name))
        return tuple(person for person in found if form(person.group) == form(name))

    def _like(self, name: str, id_: str, team: tuple[Person, ...]) -> tuple[Person, ...]:
        """Return who is called so or has this id, where neither is what counts, and the group."""
        found = [*self._all("name", folded(name)), *self._all("squeezed", squeezed(name))]
        found += [person for kind in STRONG for person in self._all(kind, id_) if id_]
        found += self._all(GITHUB, numbered(id_)[0])
        return _each_once((*found, *team))

    def _in_group(self, name: str) -> Person | None:
        """Find somebody by `GROUP-NAME`, as Moodle calls them where students work in groups."""
        parts = name.split("-")
        found = [self._one("name", folded("-".join(parts[i:]))) for i in range(1, len(parts))]
        people = {person.key: person for person in found if person is not None}
        return next(iter(people.values())) if len(people) == 1 else None


def _only(found: tuple[Person, ...]) -> Match:
    """Return who is meant if it is one; none is guessed of several."""
    return Match(found) if len(found) == 1 else Match((), found)


def _each_once(people: Iterable[Person]) -> tuple[Person, ...]:
    return tuple({person.key: person for person in people}.values())


def is_blind(name: str) -> bool:
    """Return whether Moodle calls everybody so: its anonymous submissions have only numbers."""
    return name.strip().casefold() in BLIND


def trailing(identifier: str) -> str:
    """Return the number at the end of "Participant 4711", which is in the platform's language."""
    match = re.search(r"\d+$", identifier.strip())
    return match[0] if match else ""


# "Participant", `participant` in the language packs of mod_assign
BLIND = {
    "participant", "teilnehmer/in", "teilnehmer in", "teilnehmerin", "participante", "partecipante",
}  # fmt: skip
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
