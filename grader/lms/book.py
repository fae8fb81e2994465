"""What all gradebooks need: who has points in an exercise, by which ids, in which column."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from grader.errors import InputError
from grader.lms.clean import one_line
from grader.lms.people import NO_PERSON, NOBODY, Person, Roster, Sheet, folded
from grader.lms.told import number

MOST_NAMED = 10  # students in a remark
LOGIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@+-]*")  # a name that a platform may give a user
ANYWHERE = {"folder", "csv"}  # systems that say nothing of the gradebook


@dataclass(frozen=True)
class Task:
    """An exercise as the results name it."""

    slug: str
    number: int
    title: str
    points: float

    @property
    def heading(self) -> str:
        return f"{self.number} · {self.title}"


@dataclass(frozen=True)
class Handed:
    """How a learning platform knows what somebody handed in for one exercise."""

    system: str  # "canvas", "moodle", …; "folder" if it was none
    name: str = ""  # of the student, as in the download
    id: str = ""
    email: str = ""
    late: bool = False  # says the platform
    time: str = ""  # when, as the platform writes it; "" if it doesn't say
    extension: str = ""  # until when they had more time, as the platform writes it
    upload: int = 0  # the platform's number of the file, if it has one


@dataclass(frozen=True)
class StudentRow:
    """What is known of a student besides the work."""

    student: str  # the name of the folder
    person: Person = NO_PERSON  # in the roster
    handed: dict[str, Handed] = field(default_factory=dict)  # by exercise
    seen: tuple[str, ...] = ()  # how downloads have called them: "moodle:4711"
    unsure: bool = False  # an entry of which nobody knows yet whose it is


@dataclass(frozen=True)
class Mark:
    """What one student's work for one exercise came to."""

    exercise: str  # slug
    row: StudentRow
    points: float | None  # that count; None while there are none
    notes: tuple[str, ...] = ()  # how a person has changed them
    checks: Sequence[Mapping[str, Any]] = ()  # as the student may see them
    seconds: float = 0.0  # that the grading took [s]; 0.0: not for the student

    @property
    def student(self) -> str:
        return self.row.student

    @property
    def name(self) -> str:
        return self.row.person.label or self.student

    @property
    def handed(self) -> Handed:
        """How the platform knows the submission."""
        return self.row.handed.get(self.exercise, Handed("folder"))

    @property
    def login(self) -> str:
        """The folder's name if, without a roster, it may be the user's at the platform."""
        is_folder = self.handed.system == "folder"
        return self.student if is_folder and LOGIN.fullmatch(self.student) else ""


@dataclass
class Book:
    """A graded class as the gradebooks see it; takes down what a person should know."""

    entries: Sequence[Mark]  # of all that was handed in, by student
    students: Mapping[str, StudentRow] = field(default_factory=dict)
    roster: Roster = NOBODY
    titles: Mapping[str, str] = field(default_factory=dict)  # slug: the instructor's column
    remarks: list[str] = field(default_factory=list)

    def marks(self, task: Task) -> list[tuple[Mark, float]]:
        """Return who has points that count, with them; nobody else is in any gradebook."""
        found = [
            (mark, mark.points)
            for mark in self.entries
            if mark.exercise == task.slug and mark.points is not None
        ]
        return sorted(found, key=lambda each: each[0].student)

    @property
    def systems(self) -> set[str]:
        """The platforms that the work came from, and whose sheets the roster was."""
        used = {each.system for row in self.students.values() for each in row.handed.values()}
        return used | {sheet.kind for sheet in self.roster.sheets}

    def may_be(self, *systems: str) -> bool:
        """Return whether the class may be one of these platforms'."""
        return self.systems <= ANYWHERE or not self.systems.isdisjoint(systems)

    def sheets(self, kind: str) -> list[Sheet]:
        return [sheet for sheet in self.roster.sheets if sheet.kind == kind]

    def row_of(self, sheet: Sheet, mark: Mark) -> tuple[str, ...] | None:
        for row, place in zip(sheet.rows, sheet.people, strict=True):
            if self.roster.people[place] == mark.row.person:
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
        self.remarks.append(f"{about(text, students)}.")

    def leaves_out(self, file: str, why: str, marks: Sequence[Mark]) -> None:
        """Note whom a file leaves out, if there is anybody."""
        if marks:
            self.remark(f"{file} leaves out who {why}", [mark.student for mark in marks])


def named(students: Iterable[str], most: int = MOST_NAMED) -> str:
    """Return the first of some students in words."""
    names = [one_line(student, 60) for student in students]
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def about(text: str, students: Iterable[str]) -> str:
    """Return a sentence with the students it is about."""
    names = named(dict.fromkeys(students))
    return f"{text}: {names}" if names else text


def bare(heading: str) -> str:
    """Return a column's title without what the platforms add.

    "Goal seeking (123)" is Canvas's, "Assignment: Goal seeking (Real)" is Moodle's.
    """
    return re.sub(r"^(Assignment|Quiz):\s*|\s*\((\d+|Real)\)$", "", heading).strip()


def scaled(points: float, task: Task, most: str) -> float:
    """Return points out of those that the gradebook's column has."""
    full = number_in(most)
    return round(points / task.points * full, 2) if 0 < full < 1e6 else points


def number_in(cell: str) -> float:
    """Return the number in a sheet's cell, in any language; NaN if there is none."""
    try:
        return number(cell.replace(",", "."))
    except InputError:
        return math.nan
