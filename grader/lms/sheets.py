"""Read a roster: a gradebook's export, a grading worksheet, or a CSV of one's own.

Sources: instructure/canvas-lms, lib/gradebook_exporter.rb (columns; a name that begins with `=` is
written as `="=…"`); moodle/moodle, grade/export/txt/grade_export_txt.php, and
mod/assign/gradingtable.php for the worksheet (`Identifier` is "Participant 4711"). Gradescope's
roster and GitHub Classroom's `classroom_roster.csv` have the columns below.
"""

import csv
import io
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import IO

from grader.errors import InputError
from grader.lms.moodle import columns
from grader.lms.people import (
    EMAIL,
    GITHUB,
    LOGIN,
    NUMBER,
    OWN,
    SIS,
    Person,
    Roster,
    Sheet,
    in_order,
    trailing,
    unquoted,
)
from grader.lms.platforms import PLATFORMS
from grader.lms.unpack import OF_CLASS
from rclpy_virtual_time import FileReader

MAX_SHEET = 20 * 1024 * 1024  # [bytes]
MAX_ROWS = 20_000
MAX_CELLS = 1_000_000

# heading, in small letters: what it is. Several kinds of sheets in one table: they don't collide.
IDS = {
    "sis user id": SIS, "sis login id": LOGIN, "login": LOGIN, "login id": LOGIN,
    "username": LOGIN, "user name": LOGIN, "email": EMAIL, "email address": EMAIL,
    "e-mail": EMAIL, "id number": NUMBER, "idnumber": NUMBER, "sid": SIS, "student id": OWN,
    "github_username": GITHUB, "github": GITHUB, "identifier": OWN, "id": OWN,
    "roster_identifier": OWN,
}  # fmt: skip
GROUP = ("group", "group name", "group_name", "team")
NAMES = ("student", "name", "full name", "student name")
FIRST = ("first name", "firstname", "first_name")
LAST = ("last name", "surname", "lastname", "last_name")
SECTION = ("section", "sections", "group", "groups", "section name")
TEST_STUDENT = re.compile(r"[0-9a-f]{40}")  # the login of Canvas's student view (course.rb)
HELP = (
    "expected a CSV with headings: Canvas's or Moodle's gradebook export, Moodle's grading "
    "worksheet, Gradescope's or GitHub Classroom's roster, or your own with the columns "
    "id, name, section (and email, login, github)"
)


def read_roster(files: Sequence[Path]) -> Roster:
    """Return everybody in these files; one person may be in several.

    Raises InputError: a file is none of the known kinds, or has two people with one id.
    """
    people: list[Person] = []
    sheets = []
    for file in files:
        kind, header, every, english = _read(file)
        rows = [row for row in every if _is_person(kind, header, row)]
        found = [_person(kind, english or header, row) for row in rows]
        places = _merge(people, _typed_once(found) if kind == "gradescope" else found, file)
        possible = next((row for row in every if "Points Possible" in row[0]), ())
        points = dict(zip(header, possible, strict=False))
        sheets.append(Sheet(file, kind, header, tuple(rows), places, points, english))
    return Roster(tuple(people), tuple(sheets))


def _typed_once(people: Sequence[Person]) -> list[Person]:
    """Leave out numbers that two have: students type them there, and an address tells who it is."""
    count = Counter(person.ids.get(SIS, "").casefold() for person in people)
    twice = {number for number, many in count.items() if many > 1}
    return [
        replace(person, ids={kind: id_ for kind, id_ in person.ids.items() if kind != SIS})
        if EMAIL in person.ids and person.ids.get(SIS, "").casefold() in twice else person
        for person in people
    ]  # fmt: skip


def _merge(people: list[Person], found: Sequence[Person], file: Path) -> tuple[int, ...]:
    """Add the people of a file to those of the others; return where each is."""
    places: list[int] = []
    known = Roster(tuple(people))
    keys: set[str] = set()
    for person in found:
        key = person.key.casefold()  # platforms differ in whether capitals count
        place = None if key in keys else _known(known, person)
        if place is None:
            people.append(person)
            place = len(people) - 1
        else:
            old = people[place]
            _refuse_contrary(file, old, person)
            people[place] = replace(
                old,
                section=old.section or person.section,
                ids={**person.ids, **old.ids},
                participants=old.participants | person.participants,
                group=old.group or person.group,
            )
        if place in places or key in keys:
            raise InputError(
                f"{file}: expected a row per person, but two are {person.name!r} "
                f"({person.key}; capitals don't count); remove one"
                f"{'' if person.ids else ', or add a column id'}"
            )
        keys.add(key)
        places.append(place)
    return tuple(places)


def _refuse_contrary(file: Path, old: Person, person: Person) -> None:
    """Refuse two ID numbers for one person: an export would give somebody another's points."""
    mine, theirs = person.ids.get(NUMBER, ""), old.ids.get(NUMBER, "")
    if mine and theirs and mine.casefold() != theirs.casefold():
        raise InputError(
            f"{file}: expected one ID number per person, but {person.name!r} has {mine!r} here "
            f"and {theirs!r} in another roster; correct one of them"
        )


def _known(known: Roster, person: Person) -> int | None:
    """Return the place of a person of another file: by an id, else by a name that only one has."""
    for kind in in_order(person.ids):
        for place, other in enumerate(known.people):
            mine, theirs = person.ids.get(kind, ""), other.ids.get(kind, "")
            if mine and mine.casefold() == theirs.casefold():
                return place
    same = [i for i, other in enumerate(known.people) if other.names & person.names]
    contrary = same and any(
        person.ids.get(kind) and known.people[same[0]].ids.get(kind) for kind in person.ids
    )
    return same[0] if len(same) == 1 and not contrary else None


# --- one file ------------------------------------------------------------------------------------


Lines = list[tuple[str, ...]]


def _read(file: Path) -> tuple[str, tuple[str, ...], Lines, tuple[str, ...]]:
    """Return a file's kind, headings and rows, and the headings in English if they aren't."""
    try:
        lines = OF_CLASS.read(lines_in, file=file.resolve(), returns=list[tuple[str, ...]])
    except OSError as error:
        raise InputError(f"{file}: cannot read the roster ({error.strerror})") from None
    except FileReader.Broken as error:
        raise InputError(f"{file}: a broken CSV ({error}); {HELP}") from None
    except FileReader.Refused as error:
        raise InputError(f"{file}: {error}; {HELP}") from None
    header = tuple(heading.strip() for heading in lines[0])
    rows = [(*line, *[""] * len(header))[: len(header)] for line in lines[1:]]
    english = columns(header, rows)
    kind = _kind(english or header)
    if not kind:
        raise InputError(f"{file}: the headings are {', '.join(header)[:200]!r}; {HELP}")
    return kind, header, rows, english


def lines_in(file: IO[bytes]) -> list[list[str]]:
    """Return the rows of a CSV, no longer than its first, the headings.

    Raises FileReader.Refused: it is too large, or empty.
    """
    data = file.read(MAX_SHEET + 1)
    if len(data) > MAX_SHEET:
        raise FileReader.Refused(f"over {MAX_SHEET:,} bytes")
    lines = list(islice(_rows(decoded(data)), MAX_ROWS + 1))
    if not lines or len(lines) > MAX_ROWS:
        raise FileReader.Refused(f"{len(lines):,} lines")
    columns = len(lines[0])
    if columns * len(lines) > MAX_CELLS:
        raise FileReader.Refused(f"{len(lines):,} lines of {columns:,} columns")
    return [line[:columns] for line in lines]


def decoded(data: bytes) -> str:
    """Return the text of a file, whatever spreadsheet has written it."""
    for encoding in ("utf-8-sig", "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8"):
        try:
            return data.decode(encoding)
        except ValueError:
            continue
    return data.decode("cp1252", "replace")  # Excel's "CSV" in Western Europe


def _rows(text: str) -> Iterator[list[str]]:
    first = text.partition("\n")[0]
    delimiter = max(",;\t", key=first.count)
    for line in csv.reader(io.StringIO(text, newline=""), delimiter=delimiter):
        if any(cell.strip() for cell in line):
            yield line


def _kind(header: Sequence[str]) -> str:
    small = [heading.casefold() for heading in header]
    kind = next(filter(None, (platform.sheet(small) for platform in PLATFORMS[::-1])), "")
    named = any(each in IDS or each in (*NAMES, *FIRST, *LAST) for each in small)
    return kind or ("csv" if named else "")


def _is_person(kind: str, header: Sequence[str], row: Sequence[str]) -> bool:
    """Return whether a row is a student; Canvas has two more without an id, and one for tests."""
    if kind == "gradescope":
        cells = dict(zip(map(str.casefold, header), row, strict=True))
        return cells.get("role", "").strip().casefold() in ("", "student")
    if kind != "canvas":
        return True
    about = dict(zip(header, map(str.strip, row), strict=True))
    tests = TEST_STUDENT.fullmatch(about.get("SIS Login ID", ""))
    return bool(about.get("ID")) and not tests and "Points Possible" not in row[0]


def _person(kind: str, header: Sequence[str], row: Sequence[str]) -> Person:
    cells = {heading.casefold(): cell.strip() for heading, cell in zip(header, row, strict=True)}
    participants: frozenset[str] = frozenset()
    identifier = ""
    ids: dict[str, str] = {}
    columns = next((each.columns[kind] for each in PLATFORMS if kind in each.columns), IDS)
    for heading, id_kind in columns.items():
        if cells.get(heading):
            ids.setdefault(id_kind, cells[heading])
    if kind in ("canvas", "groups") and "@" in ids.get(LOGIN, ""):
        ids[EMAIL] = ids[LOGIN]
    if kind == "worksheet":  # "Participant 4711", in the platform's language
        identifier = ids.pop(OWN, "")
        participants = frozenset({trailing(identifier)} - {""})
    if repository := cells.get("student_repository_name", ""):
        participants = frozenset({repository.casefold()})
    name = _first(cells, NAMES)
    if not name:
        first, last = (unquoted(_first(cells, each)) for each in (FIRST, LAST))
        name = f"{last}, {first}" if kind == "canvas" and first else f"{first} {last}".strip()
    name = unquoted(name)
    if kind == "github" and not name:
        name = ids.get(OWN, "")
    name = name or next(iter(ids.values()), "") or identifier  # anonymous submissions
    return Person(name, _first(cells, SECTION), ids, participants, _first(cells, GROUP))


def _first(cells: Mapping[str, str], headings: Sequence[str]) -> str:
    return next((cells[heading] for heading in headings if cells.get(heading)), "")
