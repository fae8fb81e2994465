"""What became of each file that was handed in: nothing is lost without a line."""

from dataclasses import dataclass
from enum import StrEnum

from grader.lms.tables import csv_text

MOST = 20  # lines at the terminal
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

    def counts(self) -> dict[str, str]:
        """Return how many students and files each state is about, in words."""
        found = {}
        for state in Fate:
            lines = [line for line in self.lines if line.state == state]
            people, files = {line.student for line in lines} - {""}, [x for x in lines if x.file]
            told = (many(len(people), "student"), many(len(files), "file"))
            if lines:
                found[str(state)] = ", ".join(filter(None, told)) or str(len(lines))
        return found

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


def many(count: int, what: str) -> str:
    """Return so many of something in words; "" if none."""
    return f"{count} {what}{'s' * (count > 1)}" if count else ""
