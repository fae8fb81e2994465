"""What a learning platform is to a class: its downloads, its lists of people, its gradebook."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from grader.lms.book import Book, Mark, Task
from grader.lms.people import Match, Person, Roster, folded, only


@dataclass(frozen=True)
class Who:
    """A student as a download names them."""

    name: str  # "leecarla", "Ann Lee", "bob"
    platform: Platform = field(repr=False)  # that read it
    id: str = ""  # the platform's own id, unique in one download
    email: str = ""
    anonymous: bool = False  # the download hides names


@dataclass(frozen=True)
class Entry:
    """A file, folder or archive of a download, and whose it is."""

    path: Path
    who: Who
    called: str = ""  # what the student called it; "": what it is called now
    version: int = 0  # of two files with one name, the higher is newer
    late: bool = False  # says the platform
    time: str = ""  # when it was handed in, as the platform writes it
    upload: int = 0  # the platform's number of the file, if it has one

    @property
    def word(self) -> str:
        """What is the same for this student's entries in every download, and for no other's."""
        platform = self.who.platform
        return platform.word_of(platform.key_of(self))


@dataclass(frozen=True)
class SetAside:
    """Something in a download that is not graded."""

    name: str  # where it lies in the download
    reason: str
    fault: bool = True  # a person should look; False for what is known to be of no interest


@dataclass(frozen=True)
class Read:
    """What a platform made of a download."""

    entries: list[Entry] = field(default_factory=list)
    set_aside: list[SetAside] = field(default_factory=list)
    left: list[Path] = field(default_factory=list)  # for the next platform
    # the ways to read a name that has several; a roster may know which is right
    unclear: list[list[Entry]] = field(default_factory=list)


Files = Mapping[str, str]  # path below the class's folder: content
Reads = Callable[[Path, Sequence[Path]], Read]
Fills = Callable[[Book, Sequence[Task]], Files]
Packs = Callable[[BinaryIO, Sequence[Mark], Task, Path], None]


def by_name(roster: Roster, who: Who) -> Match:
    """Return the group of that name, or the only person."""
    if team := roster.team(who.name, folded):
        return Match(team, sure=True)
    return only(roster.every("name", folded(who.name)))


def by_words(roster: Roster, who: Who, place: str) -> Match:
    """Return the person whom any word of the download means, as an id of any kind; else by name."""
    found = roster.by_word(who.id, who.email, who.name)
    return by_name(roster, who) if found is None else Match((found,), sure=True)


def by_key(
    roster: Roster, who: Who, found: Person | None, team: tuple[Person, ...] = ()
) -> Match:  # fmt: skip
    """Return the person whom the platform's own key means; it counts alone."""
    return Match((found,), sure=True) if found else Match((), roster.like(who.name, who.id, team))


@dataclass(frozen=True, eq=False)
class Platform:
    """One platform; what it does not have is left out."""

    name: str  # "Canvas"; "" for plain folders
    word: str  # what the store calls it, also in front of its ids: "canvas"
    # The entries among the paths of a folder. Nothing is opened or followed but the platform's own
    # files, and what it does not know is left for the next.
    read: Reads
    # The kind of a CSV with these headings, in small letters, if it is one of the platform's.
    sheet: Callable[[Sequence[str]], str] = lambda header: ""
    # The files that it imports; held gradings are in none.
    gradebook: Fills = lambda book, tasks: {}
    feedback: Packs | None = None  # writes a zip of the pages in a folder, as it takes them back
    folder: str = ""  # of its files; made anew each time

    # --- identity: whom an entry means -----------------------------------------------------------
    id_kind: str = ""  # of its ids in a roster; "": rosters have none of them
    folds: bool = False  # capitals of its ids don't count
    per_assignment: bool = False  # its numbers are those of a single assignment
    squeezes: bool = False  # its names are letters without spaces, so the id belongs to a name
    # What is the same in all downloads for the student of an entry, and for nobody else.
    key_of: Callable[[Entry], str] = lambda entry: entry.who.id or entry.who.name
    # Whom an entry means, by what the download calls the student and the entry itself. The
    # platform's own key counts alone where the roster has it: students choose their names.
    match: Callable[[Roster, Who, str], Match] = by_words
    # The id of a person in the assignment of a group, where that is not the id of `id_kind`.
    member: Callable[[Roster, Person, str], str] | None = None
    # The kinds of ids by small headings, for each kind of sheet that has headings of its own.
    columns: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    metadata: str = ""  # a file that only its downloads have

    # --- times -----------------------------------------------------------------------------------
    # The time of a submission and the end of an extension in the roster's sheets; "": none is told.
    times: Callable[[Roster, Person | None, Entry], tuple[str, str]] = lambda *_: ("", "")
    local_times: bool = False  # they name no zone, and are those of the class's
    marks_late: bool = False  # what it does not call late is in time

    def word_of(self, id_: str) -> str:
        """Return how the store remembers a student of the platform."""
        return f"{self.word}:{id_.casefold() if self.folds else id_}"

    def words_of(self, person: Person) -> list[str]:
        """Return how the store may remember a person of the roster."""
        ids = sorted(person.participants) if self.per_assignment else [person.ids.get(self.id_kind)]
        return [self.word_of(id_) for id_ in ids if id_]

    def member_id(self, roster: Roster, person: Person, group: str) -> str:
        if self.member is not None:
            return self.member(roster, person, group)
        return person.ids.get(self.id_kind, "")
