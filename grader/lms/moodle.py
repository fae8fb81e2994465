"""Moodle: a folder per student, grading worksheet, feedback files.

Sources, in moodle/moodle:

- mod/assign/classes/downloader.php (`get_student_prefix`, `load_submissionplugin_filelist`):
  `FULLNAME_ID_assignsubmission_file`, with `_` in the name turned into a space, then the student's
  folders and files, or `_FILENAME` if "Download submissions in folders" is off; up to Moodle 4.0 a
  folder ended in `_`. The id is that of the participant in this one assignment, as in its grading
  worksheet. Group submissions are `GROUP_ID_assignsubmission_file`.
- mod/assign/feedback/offline/importgradeslib.php and locallib.php: the worksheet needs
  `Identifier` ("Participant 4711"), `Grade` and `Last modified (grade)`. Rows are skipped whose
  grade is blank, above the maximum, or older than Moodle's. Columns of feedback replace feedback.
- mod/assign/gradingtable.php, col_grademax: the maximum is minus a scale's number, zero without
  grades.
- mod/assign/feedback/file/importziplib.php: folders `NAME_ID_assignfeedback_file`, split at `_`.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import BinaryIO

from grader.lms.book import Book, Mark, Task, number_in, scaled
from grader.lms.clean import one_line
from grader.lms.names import student_id
from grader.lms.people import (
    PARTICIPANT,
    Match,
    Person,
    Roster,
    Sheet,
    each_once,
    folded,
    only,
    squeezed,
    trailing,
)
from grader.lms.platform import Entry, Files, Platform, Read, Who
from grader.lms.tables import Cell, Verbatim, csv_text, pack
from grader.lms.told import IN_WORDS

_WHO = r"(?P<name>[^_]+)(?:_(?P<id>\d+))?_assignsubmission_(?P<plugin>file|onlinetext)"
FOLDER = re.compile(rf"{_WHO}_?")
FLAT = re.compile(rf"{_WHO}_(?P<file>.+)", re.DOTALL)

DOWNLOADED = "Last downloaded from this course"
# What identifies somebody in other languages, by lang/*/moodle.php of the language packs
WORDS = {
    "vorname": "first name", "nachname": "last name", "id-nummer": "id number",
    "e-mail-adresse": "email address", "anmeldename": "username", "gruppe": "group",
    "vollständiger name": "full name",
    "prénom": "first name", "nom de famille": "last name", "numéro d'identification": "id number",
    "adresse de courriel": "email address", "nom d'utilisateur": "username", "groupe": "group",
    "nom complet": "full name",
    "nombre": "first name", "apellido(s)": "last name", "número de id": "id number",
    "dirección de correo": "email address", "nombre de usuario": "username", "grupo": "group",
    "nombre completo": "full name", "gruppo": "group",
}  # fmt: skip
NO = {"no", "nein", "non", "não", "nee", "nej", "nei", "ne", "nie", "нет", "否", "いいえ"}
IDENTIFIER, GRADE, MOST = "identifier", "grade", "maximum grade"
CHANGEABLE, GRADED_AT = "grade can be changed", "last modified (grade)"
SUBMITTED = "last modified (submission)"
WORKSHEET = ("Identifier", "Full name", "Grade", "Maximum grade", "Last modified (grade)")
LOCKED = "has a grade that can't be changed"
KIND = "worksheet"  # of a roster's sheet
# "Participant", `participant` in the language packs of mod_assign
BLIND = {
    "participant", "teilnehmer/in", "teilnehmer in", "teilnehmerin", "participante", "partecipante",
}  # fmt: skip


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return folders and files with Moodle's prefix."""
    found = Read()
    for path in paths:
        match = (FOLDER if path.is_dir() else FLAT).fullmatch(path.name)
        if match is None or path.is_symlink():
            found.left.append(path)
        else:
            called = "" if path.is_dir() else match["file"]
            name = match["name"]
            who = Who(name, PLATFORM, match["id"] or "", anonymous=_is_blind(name))
            found.entries.append(Entry(path, who, called))
    return found


def match(roster: Roster, who: Who, place: str) -> Match:
    """Return whom Moodle's prefix means: a participant, or a group whose number is its own."""
    name = who.name
    holder = roster.one(PARTICIPANT, who.id) if who.id else None
    named, team = roster.every("name", folded(name)), roster.team(name, folded)
    forms = map(squeezed, (holder.name, holder.label)) if holder else ()
    in_group = _in_group(roster, name)
    if holder and (_is_blind(name) or squeezed(name) in forms or in_group == holder):
        return Match((holder,), sure=True)
    if team:
        return Match((), (*named, *team)) if named else Match(team, sure=True)
    if holder:  # renamed, or a group's number: who is it?
        return Match((), each_once((holder, *named)))
    return Match((in_group,)) if in_group and not named else only(named)


def _in_group(roster: Roster, name: str) -> Person | None:
    """Find a person by `GROUP-NAME`, as Moodle calls those who work in groups."""
    parts = name.split("-")
    found = [roster.one("name", folded("-".join(parts[i:]))) for i in range(1, len(parts))]
    people = each_once(person for person in found if person is not None)
    return people[0] if len(people) == 1 else None


def _is_blind(name: str) -> bool:
    """Return whether Moodle calls everybody so: its anonymous submissions have only numbers."""
    return name.strip().casefold() in BLIND


def member(roster: Roster, person: Person, group: str) -> str:
    """Return the number by which Moodle knows a member in a group's assignment."""
    for sheet in roster.sheets:
        for row, place in zip(sheet.rows, sheet.people, strict=True):
            mine = roster.people[place] == person and sheet.kind == KIND
            if mine and folded(sheet.cell(row, "group")) == folded(group):
                return trailing(sheet.cell(row, IDENTIFIER))
    return min(person.participants, default="")


def sheet(header: Sequence[str]) -> str:
    """Return the kind of a grading worksheet, or of a gradebook's export."""
    if {IDENTIFIER, GRADE} <= set(header):
        return KIND
    named = {"first name", "last name", "surname", "full name", "name"} & set(header)
    exported = DOWNLOADED.casefold() in header or ("id number" in header and named)
    return "moodle" if exported else ""


def columns(header: Sequence[str], rows: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return the headings of a worksheet or an export as Moodle has them in English.

    A worksheet's columns are told by what is in them, in the order of mod/assign/gradingtable.php;
    () if this is none.
    """
    if IDENTIFIER in map(str.casefold, header):
        return ()
    found = [WORDS.get(each.casefold().replace("\u2019", "'"), each) for each in header]
    if not rows or _participants(rows, 0) is None:
        return tuple(found) if _is_stamped(found, rows) else ()
    most = next((i for i in range(2, len(header) - 1) if _is_maximum(rows, i)), 0)
    if not most:
        return ()
    found[0], found[most - 1], found[most] = IDENTIFIER, GRADE, MOST
    found[1] = "full name" if _are_names(rows) else found[1]
    for i in range(1, most - 1):
        if all("@" in row[i] for row in rows if row[i].strip()) and any(row[i] for row in rows):
            found[i] = "email address"
    changeable = next(
        (i for i in range(most + 1, len(header)) if len({row[i] for row in rows}) <= 2
         and not any(re.search(r"\d", row[i]) for row in rows)), most + 1,
    )  # fmt: skip
    found[changeable] = CHANGEABLE
    times = [i for i in range(changeable + 1, len(header)) if _are_times(rows, i)]
    if len(times) > 1:
        found[times[0]] = SUBMITTED
    if times:
        found[times[-1]] = GRADED_AT
    return tuple(found)


def _participants(rows: Sequence[Sequence[str]], column: int) -> str | None:
    """Return the word in front of everybody's number, "Teilnehmer/in"; None if there is none."""
    found = [re.fullmatch(r"(\D*?) ?(\d+)", row[column].strip()) for row in rows]
    words = {match[1] if match else "" for match in found}
    return words.pop() if len(words) == 1 and "" not in words else None


def _is_maximum(rows: Sequence[Sequence[str]], column: int) -> bool:
    points = re.compile(r"-?\d+([.,]\d+)?")
    most = {row[column].strip() for row in rows}
    before = {row[column - 1].strip() for row in rows} - {"", "-"}
    return len(most) == 1 and all(map(points.fullmatch, most | before))


def _are_names(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether the second column is names; of anonymous submissions it is their status."""
    cells = [row[1].strip() for row in rows]
    return len(set(cells)) > len(cells) / 2 and not any(map(IN_WORDS.search, cells))


def _are_times(rows: Sequence[Sequence[str]], column: int) -> bool:
    cells = {row[column].strip() for row in rows} - {"-"}
    return not cells or ("" not in cells and all(map(IN_WORDS.search, cells)))


def _is_stamped(header: Sequence[str], rows: Sequence[Sequence[str]]) -> bool:
    """Return whether this is a gradebook's export, which ends with when it was made."""
    ends = {row[-1].strip() for row in rows}
    return len(ends) == 1 and ends.pop().isdecimal() and "email address" in header


def times(roster: Roster, person: Person | None, entry: Entry) -> tuple[str, str]:
    """Return the time of a person's submission and the end of an extension, by the worksheet."""
    for sheet in roster.sheets:
        for row, place in zip(sheet.rows, sheet.people, strict=True):
            if roster.people[place] != person:
                continue
            if sheet.kind == KIND and entry.who.id == trailing(sheet.cell(row, IDENTIFIER)):
                told = sheet.cell(row, SUBMITTED)
                before = " ".join(row[: sheet.small.index(GRADE)])  # its status among them
                more = IN_WORDS.search(before)
                return ("" if told == "-" else told), (more[0] if more else "")
    return "", ""


def gradebook(book: Book, tasks: Sequence[Task]) -> Files:
    if not book.may_be("moodle", KIND):
        return {}
    made = {_file(task): worksheet_csv(book, task, alone=len(tasks) == 1) for task in tasks}
    return {name: text for name, text in made.items() if text}


def _file(task: Task) -> str:
    return f"moodle/{task.slug}-worksheet.csv"


def worksheet_csv(book: Book, task: Task, *, alone: bool = True) -> str | None:
    """Return one exercise's grading worksheet; None if nobody in it can be identified.

    Filled in is the roster's worksheet with this assignment's participants; of a class with one
    exercise `alone` its only worksheet, wherever the work came from.
    """
    every, sheets = book.marks(task), [each for each in book.sheets(KIND) if each.rows]
    here = [(mark, points) for mark, points in every if mark.handed.system == "moodle"]
    ids = {mark.handed.id for mark, _ in here}
    found = [each for each in sheets if ids & _by_participant(each).keys()]
    if not here and alone and len(sheets) == 1:
        found = sheets
    if found:
        return None if _is_scale(book, task, found[0]) else _filled_in(book, task, found[0], every)
    plain: list[list[Cell]] = [
        [Verbatim(f"Participant {mark.handed.id}"), mark.name, points, task.points, Verbatim("-")]
        for mark, points in here
    ]
    return csv_text([list(map(Verbatim, WORKSHEET)), *plain]) if plain else None


def _by_participant(worksheet: Sheet) -> Mapping[str, Sequence[str]]:
    rows = ((trailing(worksheet.cell(row, IDENTIFIER)), row) for row in worksheet.rows)
    return {digits: row for digits, row in rows if digits}


def _is_scale(book: Book, task: Task, worksheet: Sheet) -> bool:
    """Return whether an assignment has no points: minus a scale's number is there, or zero."""
    most = worksheet.cell(worksheet.rows[0], MOST)
    if not most or number_in(most) > 0:
        return False
    book.remark(
        f"{_file(task)} is not written: the assignment's maximum grade is {one_line(most, 60)!r}, "
        "so Moodle grades it on a scale or not at all; choose points in its settings"
    )
    return True


def _filled_in(
    book: Book, task: Task, worksheet: Sheet, every: Sequence[tuple[Mark, float]]
) -> str | None:
    """Return Moodle's own worksheet with the new grades, without its columns of feedback."""
    header, rows = worksheet.small, _by_participant(worksheet)
    end = header.index(GRADED_AT) + 1 if GRADED_AT in header else len(header)
    made: list[list[Cell]] = [list(map(Verbatim, worksheet.header[:end]))]
    locked, lost = [], []
    for mark, points in every:
        is_moodles = mark.handed.system == "moodle"
        row = rows.get(mark.handed.id) if is_moodles else book.row_of(worksheet, mark)
        if row is None:
            lost.append(mark)
        elif worksheet.cell(row, CHANGEABLE).casefold() in NO:
            locked.append(mark)
        else:
            cells: list[Cell] = [
                value if heading == "full name" else Verbatim(value)
                for heading, value in zip(header[:end], row[:end], strict=True)
            ]
            cells[header.index(GRADE)] = scaled(points, task, worksheet.cell(row, MOST))
            made.append(cells)
    book.leaves_out(_file(task), f"is not in {worksheet.file.name}", lost)
    book.leaves_out(_file(task), LOCKED, locked)
    return csv_text(made) if len(made) > 1 else None


def feedback(target: BinaryIO, marks: Sequence[Mark], task: Task, pages: Path) -> None:
    """Write one exercise's feedback pages as Moodle takes them back."""
    pack(target, ((f"{_folder(mark)}/{task.slug}.html", pages / mark.student / f"{task.slug}.html")
                  for mark in marks))  # fmt: skip


def _folder(mark: Mark) -> str:
    name = student_id(mark.handed.name).replace("_", " ")
    return f"{name}_{mark.handed.id}_assignfeedback_file"


PLATFORM = Platform(
    "Moodle", "moodle", read, sheet, gradebook, feedback, folder="moodle", per_assignment=True,
    match=match, member=member, times=times, local_times=True,
)  # fmt: skip
