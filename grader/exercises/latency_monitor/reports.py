"""What a node reports on /diagnostics: the form of its statuses, their levels and their values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from typing import Any

from grader.checks.case import Case, Runs, Said
from grader.checks.reading import published
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import require_allowed
from grader.exercises.latency_monitor.contract import KEYS, LEVELS, right_statistics
from grader.recording import Recording

TOPIC = "/diagnostics"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
NAME = "profiled_controller: inference"
EMPTY, COUNTED = "empty", "counted"  # tags: no call had returned by then, or some had
MOST = 1_000  # reports in one trial, of which the longest takes 65 s
TOLERANCE = 0.1  # [ms]; "12.3" is a fine way to write 12.345
PERIOD, PERIOD_TOLERANCE = 1.0, 0.15  # [s] of the reports
HALF = 0.5  # [ms] what rounding to whole milliseconds may change
NO_REPORT = "Does the timer's callback run, and is the name right, letter by letter?"


def reports(runs: Runs, *keys: str, tag: str = COUNTED, help: str = "") -> None:
    """Fail unless each report with this tag has the right values (or level); each run has one."""
    for recording, case in _reported(runs, tag):
        asked = replace(case, allowed={key: case.allowed[key] for key in keys})
        advice = slip(asked) or help
        require_allowed(recording, asked, advice, tolerance=TOLERANCE, topic=TOPIC)


def never_stale_again(runs: Runs) -> None:
    """Fail if a report says STALE though calls have returned."""
    for recording, case in _reported(runs, COUNTED):
        known = replace(case, allowed={"level": frozenset(LEVELS) - {"STALE"}})
        require_allowed(recording, known, "STALE is for an empty window.", topic=TOPIC)


def _reported(runs: Runs, tag: str) -> Iterator[tuple[Recording, Case]]:
    """Yield the reports with this tag; fail if a run has none."""
    for recording in runs:
        require_alive(recording)
        found = [case for case in cases(recording) if tag in case.tags]
        if not found:
            when = "before a call had returned" if tag == EMPTY else "after a call had returned"
            fail(
                f"no status named “{NAME}” came on {TOPIC} {when}",
                expected="one every second, and one call of predict for each scan",
                actual=f"{len(recording.of(TOPIC))} messages on {TOPIC}",
                at=min(PERIOD, recording.duration_s),
                recording=recording,
                help=NO_REPORT,
            )
        yield from ((recording, case) for case in found)


def well_formed(runs: Runs) -> None:
    """Fail unless each message has one status, with its name and eight decimal strings."""
    for recording in runs:
        require_alive(recording)
        messages = published(recording, TOPIC, DIAGNOSTICS)
        if not messages:
            fail(
                f"nothing came on {TOPIC}",
                expected="one DiagnosticArray every second",
                at=min(PERIOD, recording.duration_s),
                recording=recording,
                help=NO_REPORT,
            )
        for at, array in messages:
            if flaw := _flaw(array.status):
                expected, actual, help = flaw
                fail(
                    f"a message on {TOPIC} is not as agreed",
                    expected=expected,
                    actual=actual,
                    at=at,
                    recording=recording,
                    help=help,
                )


@lru_cache(maxsize=8)  # many checks ask for the same
def cases(recording: Recording) -> tuple[Case, ...]:
    """Return an occasion for each status of its name: its level and values, of the calls so far."""
    messages = published(recording, TOPIC, DIAGNOSTICS)
    found = ((t, status) for t, array in messages for status in array.status if status.name == NAME)
    return tuple(_case(recording, t, status) for t, status in islice(found, MOST))


def _case(recording: Recording, time: float, status: Any) -> Case:
    choices = right_statistics(recording, time)
    counted = {COUNTED if choice.latencies else EMPTY for choice in choices}
    values: dict[str, Said] = {value.key: _number(value.value) for value in status.values}
    level = int(status.level)
    return Case(
        at=time,
        what=f"the report at {time:.2f} s, on {len(choices[-1].latencies)} calls",
        tags=frozenset(counted) if len(counted) == 1 else frozenset(),
        allowed={key: tuple({choice.span(key) for choice in choices}) for key in KEYS}
        | {"level": frozenset().union(*(choice.levels for choice in choices))},
        said=values
        | {"level": LEVELS[level] if level in range(len(LEVELS)) else f"{level}, no level"},
    )


def _number(text: str) -> Said:
    """Return the number that is written there; the text if it is none."""
    try:
        number = float(text)
    except ValueError:
        return text
    return number if math.isfinite(number) else text


def slip(case: Case) -> str:
    """Say so if the first wrong value is a latency in another unit, or rounded."""
    key = case.wrong(TOLERANCE)
    if not key.endswith("_ms"):
        return ""
    number, allowed = case.said.get(key), case.allowed[key]
    if not isinstance(number, float) or not isinstance(allowed, tuple):
        return ""
    low = allowed[0][0]
    if not number or not low:
        return ""
    for factor, unit in ((1e3, "microseconds"), (1e-3, "seconds")):
        if math.isclose(number, factor * low, rel_tol=1e-2):
            return f"These are {unit}; milliseconds are asked for: 1000 times the seconds."
    if number == round(number) and abs(number - low) <= HALF:
        return "Rounded to whole milliseconds it says too little: write f'{number:.3f}'."
    return ""


def _flaw(statuses: Sequence[Any]) -> tuple[str, str, str] | None:
    """Return what is wrong with a message's form: what was expected, what came, and a help."""
    names = [status.name for status in statuses]
    if names != [NAME]:
        help = "The name has to be the same, letter by letter; status is a list of one element."
        return f"one status named “{NAME}”", ", ".join(names) or "no status", help
    values = statuses[0].values
    keys = [value.key for value in values]
    if any(keys.count(key) != 1 for key in KEYS):
        help = "status.values is a list of KeyValue(key=…, value=…)."
        return "each once: " + ", ".join(KEYS), ", ".join(keys) or "no values", help
    for value in values:
        if value.key in KEYS and isinstance(_number(value.value), str):
            help = "f'{number:.3f}'; without any call the numbers are 0.0."
            return "numbers in digits, “12.3”", f"{value.key} is “{value.value}”", help
    return None
