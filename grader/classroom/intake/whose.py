"""Whose is it: each entry of a download goes to one person, to all of a group, or is held.

A student has one key, the name of a folder, which marks, worlds, feedback and exports hang on. It
is bound to ids: those of the roster and of the platforms, as the class's store has seen them.
"""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from grader.classroom.intake.handed_in import Student
from grader.lms.book import StudentRow
from grader.lms.names import marked, student_id
from grader.lms.people import EMAIL, Match, Person, Roster, folded, in_order, squeezed
from grader.lms.platform import Entry, SetAside, Who
from grader.lms.platforms import PLATFORMS, platform_of

Read = Sequence[tuple[int, Entry]]  # entries, with the place of their download

ASSIGN = "say whose it is: course marks assign FOLDER {!r} STUDENT"
UNCLEAR = (
    "its name begins with a number, or its student's name ends with one: whose it is can't be "
    "told, of {}; {}"
)


@dataclass(frozen=True)
class Known:
    """What the store of a class knows of its students."""

    rows: Mapping[str, StudentRow] = field(default_factory=dict)  # by folder
    # an entry's word or name: whose a person has said it is
    assigned: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    # student and exercise: the file that a person has accepted
    accepted: Mapping[tuple[str, str], str] = field(default_factory=dict)


NOTHING_KNOWN = Known()


def students(
    read: Read, unclear: Sequence[Sequence[tuple[int, Entry]]], roster: Roster, known: Known
) -> tuple[list[Student], list[SetAside]]:
    """Return who is in the class with their entries, and what stays nobody's.

    Everybody in the roster is a student; so is each entry of somebody unknown, or who can't be
    told from another: that one is held.
    """
    found = list(read)
    set_aside: list[SetAside] = []
    for readings in unclear:
        right = _right(readings, roster, known)
        if right is None:
            people = " or ".join(f"{each.who.name} ({each.who.id})" for _, each in readings)
            name = readings[0][1].path.name
            set_aside.append(SetAside(name, UNCLEAR.format(people, ASSIGN.format(name))))
        else:
            found.append(right)
    return _Class(found, roster, known).students(), set_aside


def _right(
    readings: Sequence[tuple[int, Entry]], roster: Roster, known: Known
) -> tuple[int, Entry] | None:
    """Return the reading of a name whose student is in the roster, if that is one."""
    if readings and readings[0][1].path.name in known.assigned:
        return readings[0]
    fits = [
        (number, each)
        for number, each in readings
        for person in each.who.platform.match(roster, each.who, each.path.name).people[:1]
        if squeezed(each.who.name) in (squeezed(person.name), squeezed(person.group))
    ]
    return fits[0] if len(fits) == 1 else None


@dataclass(frozen=True)
class Key:
    """What tells a student from all others, while a class is taken in."""

    word: str
    # of a person in the roster or of an entry; a name that one download has once; or the folder
    # that a person has said
    kind: Literal["id", "name", "folder"] = "id"


class _Class:
    """The students as they are found, by folder."""

    def __init__(self, read: Read, roster: Roster, known: Known) -> None:
        self._read = read
        self._roster = roster
        self._known = known
        self._seen = {word: key for key, row in known.rows.items() for word in row.seen}
        self._found: dict[str, Student] = {}
        self._new: list[tuple[str, str, Key]] = []  # label, what tells it from others, its key
        self._folders: dict[Key, str] = {}

    def students(self) -> list[Student]:
        matches = self._matched()
        for person in self._roster.people:
            row = self._row_of(person)
            self._place(Key(person.key), "" if row in self._folders.values() else row,
                        person.label, person.key)  # fmt: skip
        owners = [
            self._owners(number, entry, match)
            for (number, entry), match in zip(self._read, matches, strict=True)
        ]
        self._name_new()
        for person in self._roster.people:
            folder = self._folders[Key(person.key)]
            self._found[folder] = Student(folder, person)
        for (number, entry), mine in zip(self._read, owners, strict=True):
            for key, who in mine:
                folder = self._folders[key]
                student = self._found.setdefault(folder, Student(folder))
                student.entries.append((number, replace(entry, who=who)))
        for (number, entry), match, mine in zip(self._read, matches, owners, strict=True):
            student = self._found[self._folders[mine[0][0]]]
            if student.person is None and mine[0][0].kind != "folder":
                self._hold(number, entry.who, match, student)
        return list(self._found.values())

    # --- whom an entry means ---------------------------------------------------------------------

    def _matched(self) -> list[Match]:
        """Return whom the roster finds for each entry; two of one download are never one's by name.

        Where a worksheet knows some of a download's participants, it knows them all.
        """
        found = [
            each.who.platform.match(self._roster, each.who, each.path.name)
            for _, each in self._read
        ]
        claims: defaultdict[tuple[int, str], set[str]] = defaultdict(set)
        numbered: set[int] = set()
        for (number, entry), match in zip(self._read, found, strict=True):
            for person in match.people:
                claims[number, person.key].add(entry.word)
            if match.sure and entry.who.platform.per_assignment:
                numbered.add(number)
        for i, ((number, _), match) in enumerate(zip(self._read, found, strict=True)):
            if len(match.people) == 1 and not match.sure:
                twice = len(claims[number, match.people[0].key]) > 1
                if twice or number in numbered:
                    found[i] = Match((), match.people)
        return found

    def _owners(self, number: int, entry: Entry, match: Match) -> list[tuple[Key, Who]]:
        """Return the keys of those whose entry it is, with how the platform calls them."""
        who, said = entry.who, self._known.assigned
        folders = said.get(entry.word) or said.get(entry.path.name) or ()
        for folder in folders:
            self._folders[Key(folder, "folder")] = folder
        if folders:
            return [(Key(folder, "folder"), who) for folder in folders]
        if len(match.people) > 1:
            return [(Key(each.key), self._member(each, who)) for each in match.people]
        if match.people and (match.sure or entry.word not in self._seen):
            return [(Key(match.people[0].key), who)]
        row = self._seen.get(entry.word) or ("" if match.may_be else self._same_name(number, entry))
        key = Key(entry.word)
        if not row and not match.may_be and self._alone(number, entry):
            key = Key(who.platform.word_of(folded(who.name)), "name")
        own = f"{who.name}+{who.id or entry.word}"
        original = own if who.platform.name else entry.path.name
        self._place(key, row, _label(who, held=bool(match.may_be)), original)
        return [(key, who)]

    def _member(self, person: Person, who: Who) -> Who:
        """Return how the platform knows one of a group."""
        id_ = who.platform.member_id(self._roster, person, who.name)
        return Who(person.label, who.platform, id_, person.ids.get(EMAIL, ""))

    def _alone(self, number: int, entry: Entry) -> bool:
        """Return whether a name tells who it is, where numbers are those of one assignment."""
        who = entry.who
        same = {e.who.id for n, e in self._read if n == number and e.who.name == who.name}
        return who.platform.per_assignment and len(same) == 1 and not who.anonymous

    def _same_name(self, number: int, entry: Entry) -> str:
        """Return the only student of that name under another number, if the name tells."""
        if not self._alone(number, entry):
            return ""
        name = folded(entry.who.name)
        rows = self._known.rows.values()
        same = [row.student for row in rows if name in row.person.names
                or any(folded(each.name) == name for each in row.handed.values())]  # fmt: skip
        return same[0] if len(same) == 1 else ""

    # --- folders ---------------------------------------------------------------------------------

    def _row_of(self, person: Person) -> str:
        """Return the folder that a person of the roster has in the store; "" if there is none."""
        for kind in in_order(person.ids):
            mine = person.ids[kind].casefold()
            for row in self._known.rows.values() if mine else ():
                if row.person.ids.get(kind, "").casefold() == mine:
                    return row.student
        platforms = sorted(PLATFORMS, key=lambda each: (each.per_assignment, each.word))
        for word in (word for each in platforms for word in each.words_of(person)):
            row_of = self._seen.get(word, "")
            theirs = self._known.rows[row_of].person.ids if row_of else {}
            contrary = any(person.ids.get(kind) and theirs.get(kind)
                           and person.ids[kind].casefold() != theirs[kind].casefold()
                           for kind in person.ids)  # fmt: skip
            if row_of and not contrary:
                return row_of
        return next((row.student for row in self._known.rows.values() if self._fits(person, row)),
                    "")  # fmt: skip

    def _fits(self, person: Person, row: StudentRow) -> bool:
        """Return whether a row without ids is a person's, by the only name that both have."""
        if row.person.ids:
            return False
        if row.person.name:
            return row.person.key == person.key
        each = next(iter(row.handed.values()), None)
        if each is None:
            return False
        platform = platform_of(each.system)
        found = platform.match(self._roster, Who(each.name, platform, each.id, each.email), "")
        by_name = not platform.per_assignment or not person.participants
        return found.people == (person,) and (found.sure or by_name)

    def _place(self, key: Key, row: str, label: str, original: str) -> None:
        """Give a student the folder that the store knows, or note that there is none yet."""
        if row:
            self._folders[key] = row
        elif key not in self._folders and all(key != each for *_, each in self._new):
            self._new.append((student_id(label), original, key))

    def _name_new(self) -> None:
        """Name those whom the store doesn't know; all of a name that several have are marked."""
        taken = {each.casefold() for each in (*self._known.rows, *self._folders.values())}
        called = Counter(label.casefold() for label, *_ in self._new)
        for label, original, key in sorted(self._new, key=lambda each: each[:2]):
            several = called[label.casefold()] > 1 or label.casefold() in taken
            self._folders[key] = marked(label, original, taken, always=several)
            taken.add(self._folders[key].casefold())

    def _hold(self, number: int, who: Who, match: Match, student: Student) -> None:
        """Say of what can't be told whom it may be."""
        may_be = [self._named(person) for person in match.may_be]
        row = self._known.rows.get(student.id)
        if not match.people and (row is None or row.unsure):
            may_be += self._namesakes(number, who, student)
        if may_be:
            told = ASSIGN.format(student.id)
            student.whose = f"it may be {' or '.join(may_be[:5])}; {told}"

    def _named(self, person: Person) -> str:
        ids = [*person.ids.values(), *sorted(person.participants)]
        return f"{self._folders[Key(person.key)]} ({', '.join(ids[:3])})"

    def _namesakes(self, number: int, who: Who, student: Student) -> list[str]:
        """Return the students of that name in earlier downloads, where numbers are others."""
        if not who.platform.per_assignment or who.anonymous:
            return []
        here = {each.id: [(n, e.who.name) for n, e in each.entries] for each in
                self._found.values()}  # fmt: skip
        stored = {id_: [(-1, each.name) for each in row.handed.values()]
                  for id_, row in self._known.rows.items()}  # fmt: skip
        every = {id_: here.get(id_) or stored.get(id_, []) for id_ in {**stored, **here}}
        return sorted(
            id_
            for id_, names in every.items()
            if id_ != student.id
            and any(folded(name) == folded(who.name) for _, name in names)
            and max(n for n, _ in names) < number
        )


def _label(who: Who, *, held: bool) -> str:
    if who.anonymous or (held and who.id not in ("", who.name)):
        return f"{who.name} {who.id}".strip()
    return f"{who.name}_{who.id}" if who.platform.squeezes and who.id else who.name
