"""What a node reports on /diagnostics: the form of its statuses, their levels and their values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

from grader.checks.case import Allowed, Case, Runs, Said
from grader.checks.commands import published
from grader.checks.verbs import follows
from grader.checks.verdict import fail
from grader.exercises.latency_monitor.contract import KEYS, LEVELS, right_numbers
from grader.recording import Recording

TOPIC = "/diagnostics"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
NAME = "profiled_controller: inference"
NUMBER = "a decimal number"
MOST = 1_000  # reports in one trial, of which the longest takes 65 s
TOLERANCE = 0.1  # [ms]; "12.3" is a fine way to write 12.345
PERIOD, PERIOD_TOLERANCE = 1.0, 0.15  # [s] of the reports


def reports(runs: Runs, *tags: str, help: str) -> None:
    """Fail unless the node reports what is right, on each occasion of these tags, in each run."""
    for recording in runs:
        told = published(recording, TOPIC, DIAGNOSTICS)[:MOST]
        names = dict.fromkeys(status.name for _, array in told for status in array.status)
        if names and NAME not in names:
            fail(
                "no report has a status of this name", expected=NAME, actual=", ".join(names),
                at=told[0][0], recording=recording, help="Readers of /diagnostics look for it.",
            )  # fmt: skip
        run = Runs([recording], cases)
        follows(run, *tags, help=help, tolerance=TOLERANCE, topic=TOPIC)


@lru_cache(maxsize=8)
def cases(recording: Recording) -> Sequence[Case]:
    """Return the occasions: the form of each message, and each value of a status of the name.

    A message has the tag `form`; a value its key, or `level`, and before the first call `empty`.
    Reports that never come lack all their values.
    """
    found, told = [], published(recording, TOPIC, DIAGNOSTICS)[:MOST]
    for t, array in told:
        found.append(form(t, array.status))
        for status in array.status:
            if status.name == NAME:
                found += _values(recording, t, status)
    for t in _missing(recording, [t for t, _ in told]):
        found += _values(recording, t, None)
    return found


def _missing(recording: Recording, told: Sequence[float]) -> Iterator[float]:
    """Yield the second and each later moment [s] of a silence at which a report was due.

    A single late one is the rate's matter; while predict runs for seconds, no report is due.
    """
    longest = max((call.took / 1e9 for call in recording.inferences), default=0.0)
    patience = PERIOD_TOLERANCE + recording.slack + (longest if longest > PERIOD else 0.0)
    for begin, end in pairwise([0.0, *told, recording.duration_s]):
        t = begin + 2 * PERIOD
        while t + patience < end:
            yield t
            t += PERIOD


def form(t: float, statuses: Sequence[Any]) -> Case:
    """Return the occasion of a message: it has one status, of the name, and all keys."""
    said = {value.key: _number(value.value) for each in statuses for value in each.values}
    right = dict.fromkeys(KEYS, frozenset({NUMBER}))
    return Case(
        at=t,
        what=f"the report at {t:.2f} s",
        tags=frozenset({"form"}),
        allowed={"status": frozenset({NAME}), **right},
        said={key: text if isinstance(text, str) else NUMBER for key, text in said.items()}
        | {"status": ", ".join(each.name for each in statuses) or "none"},
    )


def _values(recording: Recording, t: float, status: Any | None) -> Iterator[Case]:
    choices = right_numbers(recording, t)
    right: dict[str, Allowed] = {
        key: tuple({(least[key], most[key]) for least, most in choices}) for key in KEYS
    }
    spans = [range(int(least["level"]), int(most["level"]) + 1) for least, most in choices]
    right["level"] = frozenset(LEVELS[i] for span in spans for i in span)
    said = {value.key: _number(value.value) for value in status.values} if status else {}
    if status:
        level = int(status.level)
        said["level"] = LEVELS[level] if level in range(len(LEVELS)) else f"{level}, no level"
    what = f"the report at {t:.2f} s, on {choices[-1][0]['count']:.0f} calls"
    counted = {least["count"] > 0 for least, _ in choices}
    for key, allowed in right.items():
        tags = {key} if counted == {True} else {"empty"} if counted == {False} else set[str]()
        yield Case(t, what, frozenset(tags), {key: allowed}, said, int(status is not None))


def _number(text: str) -> Said:
    """Return the number that is written there; the text if it is none."""
    try:
        number = float(text)
    except ValueError:
        return text
    return number if math.isfinite(number) else text
