"""When inference asks its model, and about which scan."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NoReturn

import numpy as np

from grader.checks.predictions import TOLERANCE, max_speed, predictions
from grader.checks.verdict import fail
from grader.recording import Inference, Recording

ARRIVAL_HAIR = 0.02  # [s] a scan that came this shortly before an inference may be too late for it
IDLE = 0.07  # [s] from an inference to the next, if a scan is there: a tick, and a hair


def answered_calls(recording: Recording) -> list[Inference]:
    """Return the calls of predict that were answered with a number."""
    return [i for i in recording.inferences if i.method == "predict" and i.asked >= 0 and i.said]


def require_newest(recording: Recording) -> None:
    """Fail unless nearly every inference took the newest scan that there was when it started."""
    said = predictions(recording)
    arrived = np.array([prediction.scan.t for prediction in said])
    least = np.array([prediction.least for prediction in said]) - TOLERANCE
    most = np.array([prediction.most for prediction in said]) + TOLERANCE
    calls = answered_calls(recording)
    late = []
    for call in calls:
        asked = call.asked / 1e9
        there = arrived <= asked - ARRIVAL_HAIR - recording.slack
        speed = min(max(call.said[0], 0.0), max_speed(recording.scenario))
        taken = (arrived <= asked) & (least <= speed) & (speed <= most)
        if there.any() and taken.any() and not taken[np.flatnonzero(there)[-1] :].any():
            late.append((asked, asked - float(arrived[taken][-1])))
    if len(late) <= 0.05 * len(calls):
        return
    at, age = late[0]
    fail(
        "inference takes old scans, though there are newer ones",
        expected="the newest scan that there is when predict is called",
        actual=f"a scan that is {age:.2f} s old ({len(late)} of {len(calls)} calls)",
        at=at,
        recording=recording,
        help="A queue that is full drops what comes, and keeps what is old: keep only the newest.",
    )


def require_no_idling(recording: Recording) -> None:
    """Fail if inference often waits for a scan, though one came while the last call ran."""
    after_calls = [wait for _, wait in _waits(recording)]
    idle = _idle(after_calls, recording)
    if idle:
        _fail_idle(
            recording,
            idle,
            len(after_calls),
            "inference waits, though there is a newer scan",
            "A scan that comes while the model works is kept, not dropped: it is the next one.",
        )


def require_no_pause_after_failures(recording: Recording) -> None:
    """Fail if inference waits after calls that raised, and only after these."""
    waits = list(_waits(recording))
    after_failures = [wait for failed, wait in waits if failed]
    idle = _idle(after_failures, recording)
    if idle and not _idle([wait for failed, wait in waits if not failed], recording):
        _fail_idle(
            recording,
            idle,
            len(after_failures),
            "inference pauses when the model has raised",
            "A model that raised once may answer the next time: ask it about the next scan.",
        )


def _waits(recording: Recording) -> Iterator[tuple[bool, tuple[float, float]]]:
    """Yield for each call whether it raised, when it ended, and how long the next one waited [s].

    The wait is 0 if there was nothing to ask about.
    """
    scans = recording.times("/scan")
    calls = [i for i in recording.inferences if i.method == "predict" and i.asked >= 0]
    for before, after in pairwise(sorted(calls, key=lambda call: call.asked)):
        ended = before.answered / 1e9
        there = ((scans > before.asked / 1e9) & (scans < ended - ARRIVAL_HAIR)).any()
        yield before.failed, (ended, after.asked / 1e9 - ended if there else 0.0)


def _idle(waits: list[tuple[float, float]], recording: Recording) -> list[tuple[float, float]]:
    """Return the waits that are too long, if they are more than a tenth."""
    idle = [(ended, wait) for ended, wait in waits if wait > IDLE + recording.slack]
    return idle if len(idle) > 0.1 * len(waits) else []


def _fail_idle(
    recording: Recording, idle: list[tuple[float, float]], calls: int, what: str, help: str
) -> NoReturn:
    at, wait = idle[0]
    fail(
        what,
        expected=f"the next call of predict within {1000 * IDLE:.0f} ms of the last one's end",
        actual=f"{1000 * wait:.0f} ms later ({len(idle)} of {calls} calls)",
        at=at,
        recording=recording,
        help=help,
    )
