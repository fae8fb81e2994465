"""Numbers, times and words as people and platforms tell them: one reader for each.

What these return can be stored and read back: finite, in the digits 0 – 9, within a range.
"""

import contextlib
import math
import re
from datetime import UTC, datetime, tzinfo

from grader.errors import InputError
from grader.lms.clean import one_line, visible

MOST = 1e6  # points, per cent, seconds of a run
MOST_SPAN = 366 * 86400.0  # [s]
YEARS = range(1970, 2200)
LONGEST = 100  # [characters] of a time
NUMBER = re.compile(r"[0-9]+(\.[0-9]*)?(e[-+]?[0-9]+)?", re.IGNORECASE)
WHOLE = re.compile(r"[0-9]{1,9}")
SPAN = re.compile(r"([0-9]+(?:\.[0-9]+)?)\s*(s|min|m|h|d)?")
UNITS = {"s": 1, "min": 60, "m": 60, "h": 3600, "d": 86400, None: 60}
TIMES = ("%d/%m/%Y %H:%M", "%d.%m.%Y %H:%M")  # by spreadsheets
EXPECTED = (
    f"expected a time of the years {YEARS[0]} to {YEARS[-1]}, such as 2026-05-04T23:59, with or "
    "without an offset (+02:00)"
)

# `strftimedaydatetime` in Moodle's language packs: "Monday, 4 May 2026, 9:12 AM",
# "Montag, 4. Mai 2026, 09:12", "lundi 4 mai 2026, 09:12", "lunes, 4 de mayo de 2026, 09:12"
IN_WORDS = re.compile(
    r"(?:[^\W\d]+,? )?(\d{1,2})\.? (?:de )?([^\W\d]+)\.? (?:de )?(\d{4}),? "
    r"(\d{1,2}):(\d\d)(?: ([AP]M))?",
    re.IGNORECASE,
)
MONTHS = (
    "january february march april may june july august september october november december",
    "januar februar märz april mai juni juli august september oktober november dezember",
    "janvier février mars avril mai juin juillet août septembre octobre novembre décembre",
    "enero febrero marzo abril mayo junio julio agosto septiembre octubre noviembre diciembre",
)


def number(text: object, most: float = MOST) -> float:
    """Return a number from 0 to `most`.

    Raises InputError: it is none.
    """
    told = str(text).strip()
    found = float(told) if NUMBER.fullmatch(told) else math.nan
    if not found <= most:
        raise InputError(
            f"{one_line(told, 40)!r}: expected a number from 0 to {most:,.15g}, such as 8.5"
        )
    return found


def whole(text: object, least: int = 1) -> int:
    """Return a whole number of at most nine digits.

    Raises InputError: it is none, or less than `least`.
    """
    told = str(text).strip()
    if not WHOLE.fullmatch(told) or int(told) < least:
        raise InputError(f"{one_line(told, 40)!r}: expected a whole number, at least {least}")
    return int(told)


def span(text: str) -> float:
    """Return a time span, such as 15min, 2h or 1d [s]; a bare number is minutes.

    Raises InputError: it is no time span, or over a year.
    """
    match = SPAN.fullmatch(text.strip())
    found = float(match[1]) * UNITS[match[2]] if match else math.nan
    if not found <= MOST_SPAN:
        raise InputError(
            f"{one_line(text, 40)!r}: expected a time span such as 15min, 2h or 1d, at most 366d"
        )
    return found


def words(text: str, most: int, what: str = "words") -> str:
    """Return text in one line, without what can't be seen.

    Raises InputError: nothing is left of it, or it is longer than `most`.
    """
    found = " ".join(visible(text).split())
    if not 0 < len(found) <= most:
        raise InputError(f"expected {what}, at most {most} characters")
    return found


def moment(text: str, zone: tzinfo = UTC) -> datetime | None:
    """Return the moment that a text means, in this zone if it names none; None if it is no time."""
    plain = re.sub(r"\s+UTC$", "+00:00", " ".join(text[: LONGEST + 1].split()))
    if len(plain) > LONGEST or re.search(r"(?![0-9])\d", plain):
        return None
    found = _in_words(plain)
    for pattern in ("", *TIMES):
        with contextlib.suppress(ValueError):
            found = found or (
                datetime.strptime(plain, pattern) if pattern else datetime.fromisoformat(plain)
            )
    if found is None or found.year not in YEARS:
        return None
    return found if found.tzinfo else found.replace(tzinfo=zone)


def microseconds(time: str) -> int:
    """Return a time, UTC if it names no offset, as a number; 0 if it is none."""
    found = moment(time)
    return int(found.timestamp() * 1e6) if found else 0


def _in_words(text: str) -> datetime | None:
    """Return the time that Moodle has written in English, German, French or Spanish."""
    match = IN_WORDS.fullmatch(text)
    word = match[2].casefold() if match else ""
    month = next((names.split().index(word) for names in MONTHS if word in names.split()), None)
    if match is None or month is None:
        return None
    day, year, hour, minute = (int(match[i]) for i in (1, 3, 4, 5))
    if match[6]:
        hour = hour % 12 + 12 * (match[6].upper() == "PM")
    try:
        return datetime(year, month + 1, day, hour, minute)
    except ValueError:
        return None
