"""What became of each file that was handed in: nothing is lost without a line."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

from grader.classroom.intake import SetAside, Student

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

    def csv(self, clean: Callable[[str], str]) -> str:
        """Return the account as a table; `clean` makes text harmless in a spreadsheet."""
        target = io.StringIO()
        writer = csv.writer(target, lineterminator="\r\n")
        writer.writerow(HEADER)
        for line in self.lines:
            cells = (line.entry, line.file, line.student, line.exercise, line.state, line.reason)
            writer.writerow([*map(clean, cells), "yes" if line.fault else ""])
        return target.getvalue()

    def summary(self) -> list[str]:
        """Return the lines for the terminal."""
        faults = self.faults
        lines = [f"  {line}" for line in faults[:MOST]]
        if len(faults) > MOST:
            lines.append(f"  and {len(faults) - MOST} more, in the class report and in intake.csv")
        return lines


def student_lines(
    student: Student, graded: dict[int, str], other: dict[int, str], older: dict[int, str],
    suspects: Iterable[int],
) -> list[Line]:  # fmt: skip
    """Return a line for each of a student's files.

    Parameters
    ----------
    graded, other, older
        The exercise by a file's place among the student's: what is graded, what belongs to an
        exercise that is not wanted, and versions that don't count.
    suspects
        Files that may be a missing exercise under another name.
    """
    wrong = set(suspects)
    lines = []
    for place, file in enumerate(student.files):
        line = partial(Line, entry=file.entry.path.name, file=file.name, student=student.id)
        if place in graded:
            lines.append(line(GRADED, exercise=graded[place]))
        elif place in older:
            reason = "a newer one counts"
            lines.append(line(OLDER, exercise=older[place], reason=reason))
        elif place in other:
            lines.append(line(OTHER, exercise=other[place]))
        elif place in wrong:
            reason = "may be an exercise that is missing; no exercise has a file of this name"
            lines.append(line(UNKNOWN, reason=reason, fault=True))
        else:
            lines.append(line(EXTRA))
    if student.problem:  # the student is held for it
        lines.append(Line(UNREADABLE, student=student.id, reason=student.problem))
    elif not student.files:
        lines.append(Line(NOTHING, student=student.id))
    return lines


def set_aside_lines(set_aside: Sequence[SetAside]) -> list[Line]:
    """Return a line for each thing that is nobody's work."""
    return [
        Line(UNKNOWN if each.fault else LEFT_OUT, entry=each.name, reason=each.reason,
             fault=each.fault)
        for each in set_aside
    ]  # fmt: skip
