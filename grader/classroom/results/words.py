"""Numbers, times and counts in words, as the reports print them."""

from collections.abc import Collection
from datetime import UTC

from grader.lms import told
from grader.lms.book import Task
from grader.lms.clean import one_line

NOTHING = "\N{EN DASH}"


def moment(stamp: str) -> str:
    """Return an ISO 8601 time as "2026-05-04 09:12 UTC"; anything else is returned as it is."""
    found = told.moment(stamp)
    return f"{found.astimezone(UTC):%Y-%m-%d %H:%M} UTC" if found else one_line(stamp)


def points(value: float | None) -> str:
    """Return points with at most one decimal."""
    return NOTHING if value is None else f"{value:.1f}".removesuffix(".0")


def plural(n: int, word: str) -> str:
    return f"{n} {word}" if n == 1 else f"{n} {word}s"


def headings(tasks: Collection[Task]) -> list[tuple[str, str]]:
    """Return the headings of the exercises' columns, short where there are many, with a class."""
    return [(task.heading if len(tasks) <= 4 else f"Ex. {task.number}", "number") for task in tasks]
