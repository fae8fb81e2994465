"""How late a submission is: from a deadline and the times that platforms write.

Platforms differ: nbgrader's times are UTC, Gradescope's and GitHub Classroom's have an offset,
Canvas says only LATE, and Moodle's grading worksheet has times and extensions in words, without a
zone.
"""

import math
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, tzinfo
from pathlib import Path
from zoneinfo import ZoneInfo

from grader.classroom.amendments.change import Late
from grader.classroom.amendments.people import find_student
from grader.errors import InputError
from grader.lms.book import Handed, StudentRow
from grader.lms.clean import one_line
from grader.lms.platforms import platform_of
from grader.lms.sheets import read_roster
from grader.lms.told import EXPECTED, moment

DAY = 86400  # [s]
HEADINGS = (
    "time", "submitted", "submitted at", "submission time", "handed in", "timestamp",
    "last modified (submission)",
)  # fmt: skip
DAY_ALONE = re.compile(r"\d{4}-?\d\d-?\d\d")


def lateness(rule: Late, student: str, handed: Handed | None) -> tuple[int, str]:
    """Return how many days have begun since the deadline, and why that is a guess, if it is one.

    A file's time counts, else the platform's, else its word LATE. Days are those of the zone's
    clock: one of them has 23 hours a year, and one 25.
    """
    told, zone = rule.times.get(student, ""), zone_of(rule.zone) if rule.deadline else UTC
    came = moment(told, zone)
    platform = platform_of(handed.system if handed else "")
    if came is None and handed is not None:
        came = moment(handed.time, zone if platform.local_times else UTC)
    deadline = moment(rule.deadline)
    if rule.deadline and deadline is None:  # of an older version, which took any
        return 0, f"the deadline {rule.deadline} is no time to count from; nobody is late by it"
    if came is not None and deadline is not None:
        more = moment(handed.extension, zone) if handed else None
        since = max(deadline, more or deadline)
        over = came.astimezone(zone) - since.astimezone(zone)  # of one zone: by its clock
        is_late = (came - since).total_seconds() > rule.grace
        return (max(1, math.ceil(over.total_seconds() / DAY)) if is_late else 0), ""
    if handed is not None and handed.late:
        why = "the platform says only that it is late; counted as one day (--times knows more)"
        return 1, why
    if handed is None or not rule.deadline or platform.marks_late:
        return 0, ""
    return 0, "no time is known of when it was handed in; not counted as late"


def moment_of(text: str, zone: str) -> str:
    """Return a deadline as it is stored, with its offset.

    Raises InputError: it is no time, or there is no such zone.
    """
    found = moment(text, zone_of(zone))
    if found is None:
        raise InputError(f"--deadline {one_line(text)!r}: {EXPECTED}")
    if DAY_ALONE.fullmatch(text.strip()):
        raise InputError(
            f"--deadline {text!r}: expected the time of day, too; {text.strip()}T23:59 is the end "
            f"of that day, {text.strip()}T00:00 its beginning"
        )
    return found.isoformat()


def times_of(
    file: Path, zone: str, students: Sequence[str], rows: Mapping[str, StudentRow]
) -> dict[str, str]:
    """Return the times of a CSV by student: Moodle's grading worksheet, or columns id and time.

    Raises InputError: it has no such columns, a time is none, or a row is of nobody in the class.
    """
    roster = read_roster([file])
    (sheet,) = roster.sheets
    heading = next((each for each in HEADINGS if each in sheet.small), "")
    if not heading:
        raise InputError(
            f"{file}: the headings are {', '.join(sheet.header)[:200]!r}; expected id (or name, "
            "email, login) and time"
        )
    found: dict[str, str] = {}
    for row, place in zip(sheet.rows, sheet.people, strict=True):
        person, told = roster.people[place], sheet.cell(row, heading)
        if told in ("", "-"):
            continue
        came = moment(told, zone_of(zone))
        if came is None:
            raise InputError(f"{file}: {person.name}: {one_line(told)!r}; {EXPECTED}")
        words = [*person.ids.values(), *sorted(person.participants), person.label, person.name]
        student = next(filter(None, (find_student(w, students, rows) for w in words if w)), None)
        if student is None:
            raise InputError(f"{file}: nobody in this class is {person.name!r} ({person.key})")
        found[student] = came.isoformat()
    return found


def zone_of(name: str) -> tzinfo:
    """Return a time zone.

    Raises InputError: there is no such zone, or this machine knows none.
    """
    if name == "UTC":
        return UTC
    try:
        return ZoneInfo(name)
    except (KeyError, ValueError, OSError):
        raise InputError(
            f"--zone {one_line(name)!r}: expected a time zone such as Europe/Berlin or UTC; "
            "if it is one, this machine knows none: pip install tzdata"
        ) from None
