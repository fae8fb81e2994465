"""The statuses that a node published: their form, and how they are read where it is wrong.

`status_form` judges the form. The other checks read what stands there as a person would: it is
written alike in all reports, and each value stands for one number.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import lru_cache
from typing import Any, NamedTuple

from grader.checks.reading import published
from grader.checks.verdict import CheckFailed, fail
from grader.checks.wiring import require_alive
from grader.exercises.latency_monitor.contract import DIAGNOSTICS, KEYS, PERIOD, STATUS_NAME, TOPIC
from grader.recording import Recording

MOST_REPORTS = 1_000  # in one trial, of which the longest takes 6 s
ALIKE = 0.6  # keys that are the same but for their spelling: p50 and p50_ms
_LONGEST = 40  # letters of a key or a number
_MOST_KEYS = 64
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?")  # of “12.3 ms”


class Form(NamedTuple):
    """How a node writes its statuses."""

    keys: tuple[tuple[str, str], ...] = tuple(zip(KEYS, KEYS, strict=True))  # ours, and its own
    named: bool = True  # by the exercise's name
    exact: bool = True  # as the contract wants it


RIGHT_FORM = Form()


@dataclass(frozen=True)
class Report:
    """One DiagnosticStatus with the exercise's name."""

    t: float  # [s]
    level: int
    texts: dict[str, str]
    since: float = 0.0  # [s] when the report before it came
    exact: bool = True  # a value is a number and nothing else

    def number(self, key: str) -> float:
        """Return a value as a number; NaN if it is missing or no number."""
        text = self.texts.get(key, "")
        try:
            return float(text)
        except ValueError:
            found = None if self.exact else _NUMBER.search(text[:_LONGEST])
            return float(found[0].replace(",", ".")) if found else math.nan


def require_reports(recording: Recording, form: Form = RIGHT_FORM) -> list[Report]:
    """Return the reports; fail if there is none."""
    require_alive(recording)
    found: list[Report] = []
    since = 0.0
    for time, array in _messages(recording):
        found += _reports_of(array, form, time, since)
        since = time
    if not found:
        fail(
            f"no status named “{STATUS_NAME}” came on {TOPIC}",
            expected="one every second",
            actual=f"{len(recording.of(TOPIC))} messages on {TOPIC}, none with this name",
            at=min(PERIOD, recording.duration_s),
            recording=recording,
            help="Does the timer's callback run, and is the name right, letter by letter?",
        )
    if len(found) > MOST_REPORTS:
        fail(
            f"{len(found):,} statuses named “{STATUS_NAME}” came on {TOPIC}",
            expected="one every second",
            actual=f"more than {MOST_REPORTS} in {recording.duration_s:.0f} s",
            at=found[MOST_REPORTS].t,
            recording=recording,
            help="One timer of 1.0 s publishes; not each scan, not each call.",
        )
    return found


def require_form(recording: Recording) -> None:
    """Fail unless each message has one status with its eight decimal strings."""
    require_alive(recording)
    messages = _messages(recording)
    if not messages:
        require_reports(recording)
    for at, array in messages:
        statuses = array.status
        if len(statuses) != 1 or statuses[0].name != STATUS_NAME:
            names = ", ".join(f"“{status.name}”" for status in statuses) or "no status"
            fail(
                f"a message on {TOPIC} does not have exactly one status, of this name",
                expected=f"one status named “{STATUS_NAME}”",
                actual=names,
                at=at,
                recording=recording,
                help="The name has to be the same, letter by letter, blanks too."
                if len(statuses) == 1
                else "DiagnosticArray has a list of statuses; here it has one element.",
            )
        keys = [value.key for value in statuses[0].values]
        for key in KEYS:
            if keys.count(key) != 1:
                fail(
                    f"the status has {keys.count(key)} values with the key {key}",
                    expected="each of " + ", ".join(KEYS) + " once",
                    actual=", ".join(keys) or "no values",
                    at=at,
                    recording=recording,
                    help="status.values is a list of KeyValue(key=…, value=…).",
                )
        for value in statuses[0].values:
            if value.key in KEYS and not _is_decimal(value.value):
                fail(
                    f"{value.key} is not a decimal string",
                    expected="a number in digits, such as “12.3”, without a unit",
                    actual=f"“{value.value}”",
                    at=at,
                    recording=recording,
                    help="f'{number:.3f}'; without any call the numbers are 0.0.",
                )


def form_of(recording: Recording) -> Form:
    """Return how a node writes its statuses, by those of a recording."""
    try:
        require_form(recording)
    except CheckFailed:
        arrays = [array for _, array in _messages(recording)]
        statuses = [status for array in arrays[:MOST_REPORTS] for status in array.status]
        named = any(status.name == STATUS_NAME for status in statuses)
        form = Form(named=named, exact=False)
        written = [[v.key for v in _values(array.status, form)] for array in arrays[:1]]
        return form._replace(keys=_pairs(written[0])) if written else form
    return RIGHT_FORM


@lru_cache(maxsize=4)  # many checks read the same, and a node may report very often
def _messages(recording: Recording) -> list[tuple[float, Any]]:
    return published(recording, TOPIC, DIAGNOSTICS)


def _reports_of(array: Any, form: Form, time: float, since: float) -> list[Report]:
    """Return the reports of a message: in another form than the contract's it makes one."""
    statuses = [status for status in array.status if _is_meant(status, form)]
    if form.exact:
        return [
            Report(time, int(status.level), {v.key: v.value for v in status.values}, since)
            for status in statuses
        ]
    values = {v.key: v.value for v in _values(statuses, form)}
    texts = {ours: values[theirs] for ours, theirs in form.keys if theirs in values}
    return [Report(time, int(status.level), texts, since, exact=False) for status in statuses[:1]]


def _is_meant(status: Any, form: Form) -> bool:
    return status.name == STATUS_NAME or not form.named


def _values(statuses: Any, form: Form) -> list[Any]:
    return [v for status in statuses if _is_meant(status, form) for v in status.values]


def _pairs(written: list[str]) -> tuple[tuple[str, str], ...]:
    """Return which key is meant by which: the same, one alike, or the one in its place."""
    theirs = list(dict.fromkeys(written))[:_MOST_KEYS]
    found = {key: key for key in KEYS if key in theirs}
    alike = sorted(
        (-_likeness(ours, own), ours, own)
        for ours in KEYS
        for own in theirs
        if ours not in found and own not in KEYS
    )
    for less, ours, own in alike:
        if -less >= ALIKE and ours not in found and own not in found.values():
            found[ours] = own
    left = [key for key in KEYS if key not in found]
    others = [own for own in theirs if own not in found.values()]
    if len(left) == len(others):
        found |= dict(zip(left, others, strict=True))
    return tuple(found.items())


def _likeness(ours: str, own: str) -> float:
    return SequenceMatcher(None, ours, own[:_LONGEST].lower().replace(" ", "_")).ratio()


def _is_decimal(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
