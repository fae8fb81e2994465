"""What all gradebooks need: who has points in an exercise, by which ids, in which column."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from grader.classroom.results.clean import one_line
from grader.classroom.results.marks import Task, points_of
from grader.classroom.roster import NOBODY, Person, Roster, Sheet, folded
from grader.classroom.row import Handed, StoredResult, StudentRow
from grader.errors import InputError

MOST_NAMED = 10  # students in a remark
UNKNOWN = Handed("folder")
LOGIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@+-]*")  # a name that a platform may give a user


@dataclass(frozen=True)
class Mark:
    """One student's points in one exercise."""

    student: str
    row: StudentRow
    points: float
    penalty: float = 0.0  # for lateness, which is off already

    def handed(self, slug: str) -> Handed:
        """Return how the platform knows the submission."""
        return self.row.handed.get(slug, UNKNOWN)

    @property
    def name(self) -> str:
        """The name for people."""
        return self.row.name or self.student

    def login(self, slug: str) -> str:
        """Return the folder's name if, without a roster, it may be the user's at the platform."""
        is_folder = self.handed(slug).system == "folder"
        return self.student if is_folder and LOGIN.fullmatch(self.student) else ""


@dataclass
class Book:
    """A graded class as the gradebooks see it; takes down what a person should know."""

    results: Sequence[StoredResult]
    students: Mapping[str, StudentRow] = field(default_factory=dict)
    roster: Roster = NOBODY
    titles: Mapping[str, str] = field(default_factory=dict)  # slug: the instructor's column
    remarks: list[str] = field(default_factory=list)

    def marks(self, task: Task) -> list[Mark]:
        """Return who has points that count; nobody else is in any gradebook."""
        found = []
        for result in self.results:
            if result.exercise == task.slug and (points := points_of(result, task)) is not None:
                row = self.students.get(result.student, StudentRow(result.student))
                penalty = result.amended.penalty if result.amended else 0.0
                found.append(Mark(result.student, row, points, penalty))
        return sorted(found, key=lambda mark: mark.student)

    def systems(self) -> set[str]:
        """Return the platforms that the work came from, and whose sheets the roster was."""
        used = {each.system for row in self.students.values() for each in row.handed.values()}
        return used | {sheet.kind for sheet in self.roster.sheets}

    def sheets(self, kind: str) -> list[Sheet]:
        """Return the roster's sheets of that kind."""
        return [sheet for sheet in self.roster.sheets if sheet.kind == kind]

    def row_of(self, sheet: Sheet, mark: Mark) -> tuple[str, ...] | None:
        """Return a student's row in a sheet."""
        for row, place in zip(sheet.rows, sheet.people, strict=True):
            if _is(self.roster.people[place], mark.row):
                return row
        return None

    def column(self, headings: Sequence[str], task: Task) -> str:
        """Return the heading of an exercise's column; "" if it can't be told."""
        wanted = self.titles.get(task.slug, "")
        if wanted:
            same = [each for each in headings if wanted in (each, bare(each))]
        else:
            title, slug = folded(task.title), folded(task.slug)
            numbered = re.compile(rf"\bexercise {task.number}\b")
            names = {each: folded(bare(each)) for each in headings}
            same = [each for each, name in names.items() if name in (title, slug)]
            same = same or [
                each for each, name in names.items() if title in name or numbered.search(name)
            ]
        return same[0] if len(same) == 1 else ""

    def remark(self, text: str, students: Iterable[str] = ()) -> None:
        """Note something for the report, with the students it is about."""
        names = [one_line(student, 60) for student in students]
        if names:
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            text = f"{text}: {', '.join(names[:MOST_NAMED])}{more}"
        self.remarks.append(f"{text}.")


def bare(heading: str) -> str:
    """Return a column's title without what the platforms add.

    "Goal seeking (123)" is Canvas's, "Assignment: Goal seeking (Real)" is Moodle's.
    """
    return re.sub(r"^(Assignment|Quiz):\s*|\s*\((\d+|Real)\)$", "", heading).strip()


def scaled(points: float, task: Task, most: str) -> float:
    """Return points out of those that the gradebook's column has."""
    try:
        full = float(most.replace(",", "."))
    except ValueError:
        return points
    return points if not 0 < full < 1e6 else round(points / task.points * full, 2)


def column_titles(columns: Sequence[str]) -> dict[str, str]:
    """Return the titles by slug of what was told as "EXERCISE=TITLE".

    Raises
    ------
    InputError
        It has another form, or there is no such exercise.
    """
    from grader.course.exercises import find_exercise  # noqa: PLC0415  (only if asked for)

    titles = {}
    for told in columns:
        name, sign, title = told.partition("=")
        if not sign or not title.strip():
            raise InputError(
                f"--column {told!r}: expected EXERCISE=TITLE, such as '1=Homework 1 (4711)'"
            )
        titles[find_exercise(name.strip()).slug] = title.strip()
    return titles


def missing_columns(titles: Mapping[str, str], roster: Roster) -> list[str]:
    """Return a sentence for each title that was told and that no gradebook of the roster has."""
    books = [sheet for sheet in roster.sheets if sheet.kind in ("canvas", "moodle")]
    headings = [each for sheet in books for each in sheet.header]
    return [
        f"--column: no column {title!r} in {', '.join(sheet.file.name for sheet in books)}, so "
        f"importing makes a new one{_nearest(title, headings)}"
        for title in titles.values()
        if books and not any(title in (each, bare(each)) for each in headings)
    ]


def _nearest(title: str, headings: Sequence[str]) -> str:
    near = difflib.get_close_matches(title, headings, n=1)
    return f"; did you mean {one_line(near[0])!r}?" if near else ""


def _is(person: Person, row: StudentRow) -> bool:
    if person.ids or row.ids:
        return bool(person.ids) and dict(person.ids) == dict(row.ids)
    if person.participants:
        return set(person.participants) == set(row.participants)
    return person.label == row.name


def each_sheet(sheets: Sequence[Sheet], heading: str) -> Iterator[tuple[Sheet, int]]:
    """Return the sheets that have a heading, and where."""
    for sheet in sheets:
        small = [each.casefold() for each in sheet.header]
        if heading in small:
            yield sheet, small.index(heading)
