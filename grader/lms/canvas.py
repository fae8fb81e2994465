"""Canvas: flat downloads whose names carry whose they are, and "Gradebook > Import".

Sources, in instructure/canvas-lms:

- lib/content_zipper.rb: `get_filename` joins the sortable name in lower case without anything but
  word characters, `LATE`, and the user's id (`anon_` and an anonymous id where names are hidden);
  `add_upload_submission` adds the attachment's id and the display name; text entries end in
  `_text.html`, web addresses in `_link.html`. Group submissions carry the group's name and one
  member's id. A second upload of a file gets `-1` at its end, and a higher attachment id.
- lib/gradebook_importer.rb: a student is found by `ID`, then by SIS ids, then by name; an
  assignment by "Title (id)", then by its title. A blank cell over a score removes it
  (`no_change_to_value?`), a cell over "EX" ends the excuse, and a row "Points Possible" changes the
  assignment. So there is a file per exercise, which holds only students with points, and that row
  only where Canvas has to make the assignment.
- app/models/assignment.rb, `infer_comment_context_from_filename`: of the parts of a file's name
  between underscores, the first two that are numbers are the user's id and the attachment's, which
  has to be of their submission. The comment's file is called as the attachment is.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from grader.lms.book import Book, Mark, Task, scaled
from grader.lms.people import (
    CANVAS,
    LOGIN,
    SIS,
    Match,
    Roster,
    Sheet,
    folded,
    only,
    squeezed,
    unquoted,
)
from grader.lms.platform import Entry, Files, Platform, Read, Who, by_key
from grader.lms.tables import Cell, Verbatim, csv_text, number, pack

# From the left: what the student called the file can't reach the ids in front of it. But a name may
# hold what looks like ids, and in some places students choose their own: UNCLEAR says when the file
# might be another's. The roster decides then, or a person, for both would lose by a guess.
_WHO = r"(?:(?P<name>\w*?)_)??(?:(?P<late>LATE)_)?(?P<id>\d+|anon_[A-Za-z0-9]+)"
UPLOAD = re.compile(rf"{_WHO}_(?P<attachment>\d+)_(?P<file>.+)", re.DOTALL)
UNCLEAR = re.compile(r"(?:LATE_)?\d{3,}_.+", re.DOTALL)  # what seems to be the file's own name
TYPED = re.compile(rf"{_WHO}_(?P<kind>text|link)\.html")
TYPED_IN = {"text": "text typed into Canvas.html", "link": "web address.html"}

# the kinds of ids in a gradebook's export, and in the roster that comes with groups
IDS = {"id": CANVAS, "sis user id": SIS, "sis login id": LOGIN}
GROUP_IDS = {"canvas_user_id": CANVAS, "user_id": SIS, "login_id": LOGIN}
PLAIN = ("Student", "ID", "SIS Login ID", "Section")
UNTOUCHED = {"ex": "is excused in Canvas", "n/a": "is not assigned to them in Canvas"}
READ_ONLY = "read only"
NO_ROW = "has no row in Canvas"
POSSIBLE = Verbatim("    Points Possible")


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return the uploads among the files, and what was typed into a form."""
    found = Read()
    for path in paths:
        upload, typed = UPLOAD.fullmatch(path.name), TYPED.fullmatch(path.name)
        if path.is_symlink() or not path.is_file():
            found.left.append(path)
        elif upload is not None and UNCLEAR.fullmatch(upload["file"]):
            found.unclear.append(list(_readings(path)))
        elif upload is not None:
            version, late = int(upload["attachment"][:18]), upload["late"] is not None
            found.entries.append(
                Entry(path, _who(upload), upload["file"], version, late, upload=version)
            )
        elif typed is not None:  # shows what is there if there is no file
            late = typed["late"] is not None
            found.entries.append(Entry(path, _who(typed), TYPED_IN[typed["kind"]], late=late))
        else:
            found.left.append(path)
    return found


def _readings(path: Path) -> Iterator[Entry]:
    """Return all that an upload's name may mean: a number in it may be an id, or the file's own."""
    for place in re.finditer(r"(?:^|_)(?=(?:LATE_)?\d+_\d+_.)", path.name):
        rest = re.compile(r"(LATE_)?(\d+)_(\d+)_(.+)", re.DOTALL).match(path.name, place.end())
        if rest is not None and not path.name[: place.start()].endswith("_LATE"):
            who = Who(path.name[: place.start()] or rest[2], PLATFORM, rest[2])
            version = int(rest[3][:18])
            yield Entry(path, who, rest[4], version, rest[1] is not None, upload=version)


def _who(match: re.Match[str]) -> Who:
    anonymous, name = match["id"].startswith("anon_"), match["name"] or match["id"]
    return Who(name, PLATFORM, "" if anonymous else match["id"], anonymous=anonymous)


def match(roster: Roster, who: Who, place: str) -> Match:
    """Return whom a name and an id mean; of a group the download has one member's id."""
    if not who.id or CANVAS not in roster.kinds:
        if team := roster.team(who.name, folded):
            return Match(team, sure=True)
        return only(roster.every("squeezed", squeezed(who.name)))
    found, team = roster.one(CANVAS, who.id), roster.team(who.name, squeezed)
    if found is None or found not in team:
        return by_key(roster, who, found, team)
    is_own = squeezed(found.name) == squeezed(who.name)
    return Match((), team) if is_own else Match(team, sure=True)


def sheet(header: Sequence[str]) -> str:
    """Return the kind of a gradebook's export, or of the roster that comes with groups."""
    mine = header[:2] == ["student", "id"] or header[:3] == ["lastname", "firstname", "id"]
    return "canvas" if mine else "groups" if {"canvas_user_id", "group_name"} <= set(header) else ""


def gradebook(book: Book, tasks: Sequence[Task]) -> Files:
    if not book.may_be("canvas"):
        return {}
    files = {f"canvas/{task.slug}.csv": canvas_csv(book, task) for task in tasks}
    return {name: text for name, text in files.items() if text}


def canvas_csv(book: Book, task: Task) -> str | None:
    sheets = book.sheets("canvas")
    if sheets:
        return _from_sheet(book, task, sheets[0])
    rows: list[list[Cell]] = []
    lost = []
    for mark, points in book.marks(task):
        ids, handed = mark.row.person.ids, mark.handed
        id_ = ids.get("canvas") or (handed.id if handed.system == "canvas" else "")
        login = ids.get("login", "")
        if not id_ and not login and not book.roster.people:
            login = mark.login
        if id_ or login:
            rows.append(
                [mark.name, Verbatim(id_), Verbatim(login), mark.row.person.section, points]
            )
        else:
            lost.append(mark)
    book.leaves_out(f"canvas/{task.slug}.csv", NO_ROW, lost)
    title = Verbatim(book.titles.get(task.slug, task.title))
    header: list[Cell] = [*map(Verbatim, PLAIN), title]
    possible: list[Cell] = [POSSIBLE, None, None, None, task.points]
    return csv_text([header, possible, *rows]) if rows else None


def _from_sheet(book: Book, task: Task, sheet: Sheet) -> str | None:
    assignments = tuple(each for each in sheet.header if each.endswith(")"))  # with an id
    file, column = f"canvas/{task.slug}.csv", book.column(assignments or sheet.header, task)
    most = sheet.points.get(column, "") if column else ""
    if column and READ_ONLY in most:
        book.remark(f"Canvas's column {column!r} is read only: nothing is exported for it")
        return None
    end = sheet.header.index("Section") + 1 if "Section" in sheet.header else 2
    header: list[Cell] = [*map(Verbatim, sheet.header[:end]), Verbatim(column or task.title)]
    possible: list[list[Cell]] = []
    if not column:
        book.remark(
            f"Canvas's gradebook has no single column for {task.heading!r}, so importing makes "
            f"one; name it with --column '{task.number}=TITLE'"
        )
        possible = [[POSSIBLE, *[None] * (end - 1), task.points]]
    elif scaled(task.points, task, most) != task.points:
        book.remark(
            f"{file}: points are scaled from {number(task.points)} to the {most} of Canvas's "
            f"column {column!r}"
        )
    rows: list[list[Cell]] = []
    left: dict[str, list[Mark]] = {}
    names = 2 if sheet.header[0].casefold() == "lastname" else 1
    for mark, points in book.marks(task):
        row = book.row_of(sheet, mark)
        before = row[sheet.header.index(column)].strip() if row and column else ""
        why = UNTOUCHED.get(before.casefold(), "") if row else NO_ROW
        if row is None or why:
            left.setdefault(why, []).append(mark)
            continue
        called = [unquoted(name) for name in row[:names]]
        rows.append([*called, *map(Verbatim, row[names:end]), scaled(points, task, most)])
    for why, marks in left.items():
        book.leaves_out(file, why, marks)
    return csv_text([header, *possible, *rows]) if rows else None


def feedback(target: BinaryIO, marks: Sequence[Mark], task: Task, pages: Path) -> None:
    """Write one exercise's feedback pages as Canvas takes them back: named like the uploads.

    Of a group there is one: Canvas makes it a comment for all of them.
    """
    once = {mark.handed.upload: mark for mark in reversed(marks) if mark.handed.upload}
    pack(target, ((f"{squeezed(mark.handed.name)}_{mark.handed.id}_{upload}_{task.slug}.html",
                   pages / mark.student / f"{task.slug}.html")
                  for upload, mark in sorted(once.items())))  # fmt: skip


PLATFORM = Platform(
    "Canvas", "canvas", read, sheet, gradebook, feedback, folder="canvas", id_kind=CANVAS,
    squeezes=True, match=match, columns={"canvas": IDS, "groups": GROUP_IDS}, marks_late=True,
)  # fmt: skip
