"""How a node counts and measures, right or wrong: a mistake is named, and paid for, once.

`status_form`, `mean_and_max`, `percentiles` and `window` judge a node's habits, by what it reports
in `latency_times`. Other checks take them as given, but only where one of those four has failed: a
window of one second, seconds for milliseconds, and levels that follow from wrong numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from grader.exercises.latency_monitor.contract import (
    ERROR,
    EVERYTHING,
    LATENCIES,
    OK,
    STALE,
    THREE_DIGITS,
    TOLERANCE,
    WARN,
    WINDOW,
    Statistics,
    calls_by,
    deadline_of,
    right_statistics,
)
from grader.exercises.latency_monitor.reports import (
    RIGHT_FORM,
    Form,
    Report,
    form_of,
    require_reports,
)
from grader.recording import Recording

MEASURED = ("count", *LATENCIES)
COUNTED = ("deadline_ms", "missed")
# Calls in a window, to tell statistics apart: of fewer all are the same, and who reports on them
# shows none.
FEW = 5
MANY = 10  # tolerances, by which numbers differ
_POWER = 0.03  # share by which rounding may change a unit
_UNITS = 1e-9, 1e9  # least and greatest
_SHARES = (("p50_ms", 0.5), ("p95_ms", 0.95), ("p99_ms", 0.99), ("max_ms", 1.0))


class Window(NamedTuple):
    """The calls that a report is about."""

    calls: int = WINDOW
    cleared: bool = False  # after each report


LAST = Window()


@dataclass(frozen=True)
class Habits:
    """How a node reports on plain calls."""

    form: Form = RIGHT_FORM
    window: Window = LAST
    scale: float = 1.0  # by which its latencies differ from milliseconds
    right: bool = True  # what it measures is what the contract wants

    @property
    def strict(self) -> Habits:
        """The contract, in the form in which the node writes."""
        return Habits(self.form)


RIGHT = Habits()


class Wrong(NamedTuple):
    """A number in a report that is not the right one."""

    report: Report
    key: str
    number: float
    choices: tuple[Statistics, ...]  # that would have been right


def habits_of(recording: Recording, fewest: int = FEW) -> Habits:
    """Return how a node reports, by a recording of plain calls; `fewest` are a window."""
    found = Habits(form_of(recording))
    if says_right(recording, MEASURED, found):
        return found
    found = replace(found, right=False)
    for window in _windows(require_reports(recording, found.form), fewest):
        if says_right(recording, ("count",), replace(found, window=window)):
            found = replace(found, window=window)
            break
    scales = (replace(found, scale=scale) for scale in _scales(recording, found))
    wanted = ("mean_ms", "max_ms")
    return next((habits for habits in scales if says_right(recording, wanted, habits)), found)


def says_right(
    recording: Recording, keys: Iterable[str], habits: Habits, *, full_windows: bool = True
) -> bool:
    """Tell whether all these values are right, the node's habits given."""
    reports = judged(recording, habits, full_windows=full_windows)
    return next(wrong_numbers(recording, reports, keys, habits), None) is None


def counts_right(recordings: Iterable[Recording], habits: Habits) -> bool:
    """Tell whether the deadline and the missed calls are right, as long as no call is forgotten."""
    return all(
        says_right(recording, COUNTED, habits.strict, full_windows=False)
        for recording in recordings
    )


def judged(
    recording: Recording, habits: Habits, *, full_windows: bool = True, until: float = math.inf
) -> list[Report]:
    """Return the reports until a time [s], or only those before the hundred-and-first call."""
    return [
        report
        for report in require_reports(recording, habits.form)
        if report.t <= until and (full_windows or calls_by(recording, report.t) <= WINDOW)
    ]


def wrong_numbers(
    recording: Recording, reports: Iterable[Report], keys: Iterable[str], habits: Habits
) -> Iterator[Wrong]:
    """Return the values that are not right, the node's habits given."""
    for report in reports:
        choices = _choices(recording, report, habits)
        for key in keys:
            number = report.number(key)
            if not any(choice.allows(key, number, habits.scale) for choice in choices):
                yield Wrong(report, key, number, choices)


def misses_follow(recordings: Iterable[Recording], habits: Habits) -> bool:
    """Tell whether `missed` follows from the node's own percentiles, which tell of something."""
    said = [
        (report, _may_have_missed(report, deadline_of(recording)))
        for recording in recordings
        for report in judged(recording, habits, full_windows=False)
    ]
    reports = [report for report, _ in said]
    return all(follows for _, follows in said) and _differ(reports, "missed", "p95_ms")


def levels_follow(recordings: Iterable[Recording], habits: Habits) -> bool:
    """Tell whether the levels follow from the node's own numbers, which tell of something.

    The deadline is the right one or, as `missed` judges it, the one that the node says.
    """
    said = [
        (report, {_own_level(report, deadline_of(recording)),
                  _own_level(report, report.number("deadline_ms"))})
        for recording in recordings
        for report in judged(recording, habits)
    ]  # fmt: skip
    reports = [report for report, _ in said]
    shown = {report.level for report in reports} - {STALE}
    return (
        all(report.level in levels for report, levels in said)
        and len(shown) > 1
        and _differ(reports, "p95_ms")
    )


def _differ(reports: list[Report], *keys: str) -> bool:
    """Tell whether none of these values is always the same."""
    return all(len({report.number(key) for report in reports}) > 1 for key in keys)


def _own_level(report: Report, deadline: float) -> int | None:
    """Return the level that follows from a report's own numbers; none if they are not there."""
    count, p95, missed = (report.number(key) for key in ("count", "p95_ms", "missed"))
    if not all(math.isfinite(number) for number in (count, p95, missed)):
        return None
    if not count:
        return STALE
    return ERROR if p95 > deadline else WARN if missed else OK


def _may_have_missed(report: Report, deadline: float) -> bool:
    """Tell whether a report's own percentiles allow the calls that it says were missed."""
    count, missed = report.number("count"), report.number("missed")
    if not 0 <= missed <= count <= EVERYTHING:
        return False
    least, most = 0.0, count
    for key, share in _SHARES:
        latency, place = report.number(key), share * (count - 1)
        if math.isnan(latency):
            return False
        if latency > deadline:
            least = max(least, count - math.ceil(place))
        else:
            most = min(most, count - 1 - math.floor(place))
    return least <= missed <= most if count else not missed


def _choices(recording: Recording, report: Report, habits: Habits) -> tuple[Statistics, ...]:
    since = report.since if habits.window.cleared else -math.inf
    return right_statistics(recording, report.t, habits.window.calls, since)


def _windows(reports: list[Report], fewest: int) -> Iterator[Window]:
    """Return the windows that may be behind the counts."""
    yield Window()
    most = max((report.number("count") for report in reports), default=0.0)
    if most >= fewest:
        yield Window(cleared=True)
        if most < WINDOW:
            yield Window(int(most))


def _scales(recording: Recording, habits: Habits) -> Iterator[float]:
    """Return the units that may be behind the latencies, other than milliseconds.

    They have to be so great that rounding leaves something to judge.
    """
    reports = require_reports(recording, habits.form)
    last = max(reports, key=lambda report: (report.number("max_ms"), report.t))
    right = [choice.numbers["max_ms"] for choice in _choices(recording, last, habits)]
    ratio = last.number("max_ms") / max(right) if max(right) else 0.0
    if not _UNITS[0] <= ratio <= _UNITS[1]:
        return
    power = 10.0 ** round(math.log10(ratio))
    for scale in (power, ratio):
        tolerance = max(scale * TOLERANCE, THREE_DIGITS)
        near = abs(scale - ratio) <= _POWER * ratio
        if near and scale != 1.0 and scale * max(right) > MANY * tolerance:
            yield scale
