"""What became of each file that was handed in: nothing is lost without a line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from grader.classroom.intake.handed_in import Student
from grader.lms.platform import SetAside
from grader.lms.tables import csv_text

GRADED = "to be graded"
OLDER = "older version"
OTHER = "another exercise"
EXTRA = "extra file"
UNREADABLE = "not read"
UNKNOWN = "not understood"
LEFT_OUT = "left out"
STRANGER = "not in the roster"
NOTHING = "nothing handed in"
STATES = (GRADED, OLDER, OTHER, EXTRA, LEFT_OUT, UNREADABLE, NOTHING, STRANGER, UNKNOWN)
MOST = 20  # lines at the terminal
LINKS = "links, which are not followed"
CONTRARY = (
    "another work of that name came in another download, and this one does not count; "
    "was one of them handed in to the wrong assignment?"
)

SUSPECT = "may be an exercise that is missing; no exercise has a file of this name"
HEADER = ("entry", "file", "student", "exercise", "state", "reason", "look at it")


@dataclass(frozen=True)
class Line:
    """One file, one entry or one student of the account."""

    state: str  # one of STATES
    entry: str = ""  # what lies in the download
    file: str = ""  # in it, as the student called it
    student: str = ""
    exercise: str = ""
    reason: str = ""
    fault: bool = False  # a person should look
    held: bool = False  # too, and the results say so themselves

    def __str__(self) -> str:
        """Return a line for the terminal."""
        what = ": ".join(dict.fromkeys(filter(None, (self.student, self.entry, self.file))))
        return f"{self.state}: {what}" + (f" ({self.reason})" if self.reason else "")


@dataclass(frozen=True)
class Account:
    """What became of all that was handed in."""

    lines: tuple[Line, ...] = ()

    @property
    def faults(self) -> list[Line]:
        """The lines that a person should look at."""
        return [line for line in self.lines if line.fault]

    def counts(self) -> dict[str, int]:
        """Return how many lines there are of each state."""
        found = Counter(line.state for line in self.lines)
        return {state: found[state] for state in STATES if found[state]}

    def csv(self) -> str:
        """Return the account as a table."""
        return csv_text(
            [HEADER]
            + [
                (line.entry, line.file, line.student, line.exercise, line.state, line.reason,
                 "yes" if line.fault or line.held else "")
                for line in self.lines
            ]
        )  # fmt: skip

    def summary(self) -> list[str]:
        """Return the lines for the terminal."""
        faults = self.faults
        lines = [f"  {line}" for line in faults[:MOST]]
        if len(faults) > MOST:
            lines.append(f"  and {len(faults) - MOST} more, in the class report and in intake.csv")
        return lines


def student_lines(student: Student, fates: Mapping[int, Line]) -> list[Line]:
    """Return a line for each of a student's files; what became of some is given by `id(file)`."""
    lines = [
        replace(
            fates.get(id(file), Line(EXTRA)),
            entry=file.entry.path.name, file=file.name, student=student.id,
        )
        for file in student.files
    ]  # fmt: skip
    line = partial(
        Line, entry="; ".join(each.path.name for _, each in student.entries), student=student.id
    )
    if student.problem:  # the student is held for it
        lines.append(line(UNREADABLE, reason=student.problem, held=True))
    elif not student.files and student.links:
        lines.append(line(UNREADABLE, reason=LINKS, held=True))
    elif not student.files:
        lines.append(line(NOTHING))
    return lines


def set_aside_lines(set_aside: Sequence[SetAside]) -> list[Line]:
    """Return a line for each thing that is nobody's work."""
    return [
        Line(UNKNOWN if each.fault else LEFT_OUT, entry=each.name, reason=each.reason,
             fault=each.fault)
        for each in set_aside
    ]  # fmt: skip
