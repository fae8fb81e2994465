"""What a node reports on /diagnostics: the form of its statuses, their levels and their values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from typing import Any

from grader.checks.case import Case, Runs, Said
from grader.checks.commands import published
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import follows, require_allowed
from grader.exercises.latency_monitor.contract import KEYS, LEVELS, right_statistics
from grader.recording import Recording

TOPIC = "/diagnostics"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
NAME = "profiled_controller: inference"
EMPTY, COUNTED = "empty", "counted"  # tags: no call had returned by then, or some had
MOST = 1_000  # reports in one trial, of which the longest takes 65 s
TOLERANCE = 0.1  # [ms]; "12.3" is a fine way to write 12.345
PERIOD, PERIOD_TOLERANCE = 1.0, 0.15  # [s] of the reports
FORM = "form"  # tag of `forms`
ALL_KEYS, DIGITS = "each once: " + ", ".join(KEYS), "in digits, 12.3"


def reports(runs: Runs, *keys: str, tag: str = COUNTED, help: str = "") -> None:
    """Fail unless each report with this tag has the right values (or level); each run has one."""
    for recording in runs:
        require_alive(recording)
        found = [case for case in cases(recording) if tag in case.tags]
        if not found:
            when = "before a call had returned" if tag == EMPTY else "after a call had returned"
            fail(f"no status named “{NAME}” came {when}", recording=recording, help=help)
        for case in found:
            asked = replace(case, allowed={key: case.allowed[key] for key in keys})
            advice = slip(asked) or help
            require_allowed(recording, asked, advice, tolerance=TOLERANCE, topic=TOPIC)


def well_formed(runs: Runs) -> None:
    """Fail unless each message has one status, with its name and eight decimal strings."""
    help = (
        "The name has to be the same, letter by letter; status is a list of one element, and its "
        "values are KeyValue(key=…, value=f'{number:.3f}'), 0.0 without any call."
    )
    follows(Runs(runs, forms), FORM, help=help, topic=TOPIC)


def forms(recording: Recording) -> list[Case]:
    """Return an occasion for each message: whether it has the form that is agreed."""
    right = {
        "status": frozenset({NAME}),
        "keys": frozenset({ALL_KEYS}),
        "values": frozenset({DIGITS}),
    }
    return [
        Case(t, f"the report at {t:.2f} s", frozenset({FORM}), right, form(array.status))
        for t, array in published(recording, TOPIC, DIAGNOSTICS)
    ]


def form(statuses: Sequence[Any]) -> dict[str, Said]:
    """Return the names of a message's statuses, and what its keys and values are."""
    values = statuses[0].values if statuses else ()
    keys = [value.key for value in values]
    texts = [v.value for v in values if v.key in KEYS and isinstance(_number(v.value), str)]
    return {
        "status": ", ".join(status.name for status in statuses) or "none",
        "keys": ALL_KEYS if all(keys.count(key) == 1 for key in KEYS) else ", ".join(keys),
        "values": texts[0] if texts else DIGITS,
    }


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
    """Say so if the first wrong value is a latency in another unit."""
    key = case.wrong(TOLERANCE)
    number, allowed = case.said.get(key), case.allowed.get(key)
    if key.endswith("_ms") and isinstance(number, float) and isinstance(allowed, tuple):
        for factor, unit in ((1e3, "microseconds"), (1e-3, "seconds")):
            if number and math.isclose(number, factor * allowed[0][0], rel_tol=1e-2):
                return f"These are {unit}; milliseconds are asked for: 1000 times the seconds."
    return ""
