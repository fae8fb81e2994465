"""What became of each file that was handed in: nothing is lost without a line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial

from grader.classroom.intake.handed_in import Student
from grader.lms.tables import csv_text

MOST = 20  # lines at the terminal
LINKS = "links, which are not followed"
HEADER = ("entry", "file", "student", "exercise", "state", "reason", "look at it")


class Fate(StrEnum):
    """What became of it, in the order of the report."""

    GRADED = "to be graded"
    OLDER = "older version"
    OTHER = "another exercise"
    EXTRA = "extra file"
    LEFT_OUT = "left out"
    UNREADABLE = "not read"
    NOTHING = "nothing handed in"
    STRANGER = "not in the roster"
    UNKNOWN = "not understood"


@dataclass(frozen=True)
class Line:
    """One file, one entry or one student of the account."""

    state: Fate
    entry: str = ""  # what lies in the download
    file: str = ""  # in it, as the student called it
    student: str = ""
    exercise: str = ""
    reason: str = ""
    fault: bool = False  # a person should look
    held: bool = False  # too, and the results say so themselves

    def __str__(self) -> str:
        what = ": ".join(dict.fromkeys(filter(None, (self.student, self.entry, self.file))))
        return f"{self.state}: {what}" + (f" ({self.reason})" if self.reason else "")


@dataclass(frozen=True)
class Account:
    """What became of all that was handed in."""

    lines: tuple[Line, ...] = ()

    @property
    def faults(self) -> list[Line]:
        return [line for line in self.lines if line.fault]

    def counts(self) -> dict[str, int]:
        found = Counter(line.state for line in self.lines)
        return {state: found[state] for state in Fate if found[state]}

    def csv(self) -> str:
        return csv_text(
            [HEADER]
            + [
                (line.entry, line.file, line.student, line.exercise, line.state, line.reason,
                 "yes" if line.fault or line.held else "")
                for line in self.lines
            ]
        )  # fmt: skip

    def summary(self) -> list[str]:
        faults = self.faults
        lines = [f"  {line}" for line in faults[:MOST]]
        if len(faults) > MOST:
            lines.append(f"  and {len(faults) - MOST} more, in the class report and in intake.csv")
        return lines


def student_lines(student: Student, fates: Mapping[int, Line]) -> list[Line]:
    """Return a line for each of a student's files; what became of some is given by `id(file)`."""
    lines = [
        replace(
            fates.get(id(file), Line(Fate.EXTRA)),
            entry=file.entry.path.name, file=file.name, student=student.id,
        )
        for file in student.files
    ]  # fmt: skip
    line = partial(
        Line, entry="; ".join(each.path.name for _, each in student.entries), student=student.id
    )
    if student.problem:  # the student is held for it
        lines.append(line(Fate.UNREADABLE, reason=student.problem, held=True))
    elif not student.files and student.links:
        lines.append(line(Fate.UNREADABLE, reason=LINKS, held=True))
    elif not student.files:
        lines.append(line(Fate.NOTHING))
    return lines
