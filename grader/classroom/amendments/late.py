"""How late a submission is: from a deadline and the times that platforms write.

Platforms differ: nbgrader's times are UTC, Gradescope's and GitHub Classroom's have an offset,
Canvas says only LATE, and Moodle's grading worksheet has times and extensions in words, without a
zone.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, tzinfo
from pathlib import Path
from zoneinfo import ZoneInfo

from grader.classroom.amendments.change import Late
from grader.classroom.amendments.people import find_student
from grader.errors import InputError
from grader.lms.book import Handed, StudentRow
from grader.lms.moodle import moment
from grader.lms.sheets import read_roster

DAY = 86400  # [s]
TIMES = ("%d/%m/%Y %H:%M", "%d.%m.%Y %H:%M")  # by spreadsheets
HEADINGS = (
    "time", "submitted", "submitted at", "submission time", "handed in", "timestamp",
    "last modified (submission)",
)  # fmt: skip
EXPECTED = "expected a time such as 2026-05-04T23:59, with or without an offset (+02:00)"
SPAN = re.compile(r"(\d+(?:\.\d+)?)\s*(s|min|m|h|d)?")
DAY_ALONE = re.compile(r"\d{4}-?\d\d-?\d\d")
UNITS = {"s": 1, "min": 60, "m": 60, "h": 3600, "d": DAY, None: 60}


def lateness(rule: Late, student: str, handed: Handed | None) -> tuple[int, str]:
    """Return how many days have begun since the deadline, and why that is a guess, if it is one.

    A file's time counts, else the platform's, else its word LATE. Days are those of the zone's
    clock: one of them has 23 hours a year, and one 25.
    """
    told, zone = rule.times.get(student, ""), _zone(rule.zone)
    moment = parsed(told, zone) if told else None
    if moment is None and handed is not None and handed.time:
        moment = parsed(handed.time, zone if handed.system == "moodle" else UTC)
    if moment is not None and rule.deadline:
        deadline = datetime.fromisoformat(rule.deadline)
        more = parsed(handed.extension, zone) if handed else None
        since = max(deadline, more or deadline)
        over = moment.astimezone(zone) - since.astimezone(zone)  # of one zone: by its clock
        is_late = (moment - since).total_seconds() > rule.grace
        return (max(1, math.ceil(over.total_seconds() / DAY)) if is_late else 0), ""
    if handed is not None and handed.late:
        why = "the platform says only that it is late; counted as one day (--times knows more)"
        return 1, why
    if handed is None or not rule.deadline or handed.system == "canvas":  # it marks what is late
        return 0, ""
    return 0, "no time is known of when it was handed in; not counted as late"


def parsed(text: str, zone: tzinfo) -> datetime | None:
    """Return the moment that a text means, in this zone if it names none; None if it is no time."""
    plain = re.sub(r"\s+UTC$", "+00:00", " ".join(text.split()))
    if (words := moment(plain)) is not None:
        return words.replace(tzinfo=zone)
    for pattern in ("", *TIMES):
        with contextlib.suppress(ValueError):
            found = datetime.strptime(plain, pattern) if pattern else datetime.fromisoformat(plain)
            return found if found.tzinfo else found.replace(tzinfo=zone)
    return None


def moment_of(text: str, zone: str) -> str:
    """Return a deadline as it is stored, with its offset.

    Raises InputError: it is no time, or there is no such zone.
    """
    found = parsed(text, _zone(zone))
    if found is None:
        raise InputError(f"--deadline {text!r}: {EXPECTED}")
    if DAY_ALONE.fullmatch(text.strip()):
        raise InputError(
            f"--deadline {text!r}: expected the time of day, too; {text.strip()}T23:59 is the end "
            f"of that day, {text.strip()}T00:00 its beginning"
        )
    return found.isoformat()


def span_of(text: str) -> float:
    """Return a time span, such as 15min, 2h or 1d [s]; a bare number is minutes.

    Raises InputError: it is no time span.
    """
    match = SPAN.fullmatch(text.strip())
    if match is None:
        raise InputError(f"--grace {text!r}: expected a time span such as 15min, 2h or 1d")
    return float(match[1]) * UNITS[match[2]]


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
        moment = parsed(told, _zone(zone))
        if moment is None:
            raise InputError(f"{file}: {person.name}: {told!r}; {EXPECTED}")
        words = [*person.ids.values(), *sorted(person.participants), person.label, person.name]
        student = next(filter(None, (find_student(w, students, rows) for w in words if w)), None)
        if student is None:
            raise InputError(f"{file}: nobody in this class is {person.name!r} ({person.key})")
        found[student] = moment.isoformat()
    return found


def _zone(name: str) -> tzinfo:
    if name == "UTC":
        return UTC
    try:
        return ZoneInfo(name)
    except (KeyError, ValueError, OSError):
        raise InputError(
            f"--zone {name!r}: expected a time zone such as Europe/Berlin or UTC"
        ) from None
