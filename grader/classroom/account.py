"""What became of each file that was handed in: nothing is lost without a line."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Sequence
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
LINKS = "links, which are not followed"
CONTRARY = (
    "another work of that name came in another download, and this one does not count; "
    "was one of them handed in to the wrong assignment?"
)

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

    def csv(self, clean: Callable[[str], str]) -> str:
        """Return the account as a table; `clean` makes text harmless in a spreadsheet."""
        target = io.StringIO()
        writer = csv.writer(target, lineterminator="\r\n")
        writer.writerow(HEADER)
        for line in self.lines:
            cells = (line.entry, line.file, line.student, line.exercise, line.state, line.reason)
            writer.writerow([*map(clean, cells), "yes" if line.fault or line.held else ""])
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
    suspects: Iterable[int], contrary: Collection[int] = (),
) -> list[Line]:  # fmt: skip
    """Return a line for each of a student's files.

    Parameters
    ----------
    graded, other, older
        The exercise by a file's place among the student's: what is graded, what belongs to an
        exercise that is not wanted, and versions that don't count.
    suspects
        Files that may be a missing exercise under another name.
    contrary
        Of `older` those that are another work, from another download than what is graded.
    """
    wrong = set(suspects)
    lines = []
    line_of = partial(Line, entry="; ".join(student.entries), student=student.id)
    for place, file in enumerate(student.files):
        line = partial(Line, entry=file.entry.path.name, file=file.name, student=student.id)
        if place in graded:
            lines.append(line(GRADED, exercise=graded[place]))
        elif place in older:
            reason = CONTRARY if place in contrary else "a newer one counts"
            fault = place in contrary
            lines.append(line(OLDER, exercise=older[place], reason=reason, fault=fault))
        elif place in other:
            lines.append(line(OTHER, exercise=other[place]))
        elif place in wrong:
            reason = "may be an exercise that is missing; no exercise has a file of this name"
            lines.append(line(UNKNOWN, reason=reason, fault=True))
        else:
            lines.append(line(EXTRA))
    if student.problem:  # the student is held for it
        lines.append(line_of(UNREADABLE, reason=student.problem, held=True))
    elif not student.files and student.links:
        lines.append(line_of(UNREADABLE, reason=LINKS, held=True))
    elif not student.files:
        lines.append(line_of(NOTHING))
    return lines


def set_aside_lines(set_aside: Sequence[SetAside]) -> list[Line]:
    """Return a line for each thing that is nobody's work."""
    return [
        Line(UNKNOWN if each.fault else LEFT_OUT, entry=each.name, reason=each.reason,
             fault=each.fault)
        for each in set_aside
    ]  # fmt: skip
