"""The oracle of latency_monitor: the command for each scan, and the statistics of its calls."""

from __future__ import annotations

from bisect import bisect_right
from functools import lru_cache

import numpy as np

from grader.checks.case import Case
from grader.checks.contract import Contract
from grader.checks.predictions import braking, model_found, model_says_go, speed_cases
from grader.recording import Recording

KEYS = ("count", "mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms", "deadline_ms", "missed")
LEVELS = ("OK", "WARN", "ERROR", "STALE")
OK, WARN, ERROR, STALE = range(4)
Numbers = dict[str, float]  # by KEYS; and the level
WINDOW = 100  # calls
DEADLINE = 100.0  # [ms] without the parameter
NEAR = 0.001  # [s] a call that ends this near to a report may count or not
MOST_CHOICES = 20  # calls that end so near to a report
OVERHEAD = 4.0  # [ms] that a call takes longer in real time: the link, waking up, Python's own

CONTRACT = Contract(free=model_says_go, nodes=(braking("slow", seconds=0.02),))


def cases(recording: Recording) -> list[Case]:
    """Return an occasion for each scan: the command is what the model predicts, clipped.

    What a report has to say: `grader.exercises.latency_monitor.reports.cases`.
    """
    return speed_cases(recording, model_found(recording.scenario))


def right_numbers(recording: Recording, time: float) -> list[tuple[Numbers, Numbers]]:
    """Return what a report may say at a time [s]: the least and the greatest of each number.

    There are several if calls end just then: they may count or not. In real time each call may
    take longer.
    """
    overhead = 0.0 if recording.live is None else OVERHEAD
    calls, near = _calls(recording), NEAR + recording.slack
    ends = [end for end, _ in calls]
    least = bisect_right(ends, time - near - overhead / 1000.0)
    most = bisect_right(ends, time + near)
    deadline = float(recording.scenario.node.parameters.get("deadline_ms", DEADLINE))
    found = []
    for n in range(max(least, most - MOST_CHOICES), most + 1):
        window = tuple(latency for _, latency in calls[max(0, n - WINDOW) : n])
        late = tuple(latency + 1000.0 * recording.slack + overhead for latency in window)
        found.append((numbers(window, deadline), numbers(late, deadline)))
    return found


def numbers(latencies: tuple[float, ...], deadline: float) -> Numbers:
    """Return the eight values and the level, of a window of calls [ms]."""
    if not latencies:
        return dict.fromkeys(KEYS, 0.0) | {"deadline_ms": deadline, "level": STALE}
    p50, p95, p99 = np.percentile(latencies, (50, 95, 99)).tolist()
    missed = sum(latency > deadline for latency in latencies)
    return {
        "count": len(latencies),
        "mean_ms": float(np.mean(latencies)),
        "p50_ms": p50,
        "p95_ms": p95,
        "p99_ms": p99,
        "max_ms": max(latencies),
        "deadline_ms": deadline,
        "missed": missed,
        "level": ERROR if p95 > deadline else WARN if missed else OK,
    }


@lru_cache(maxsize=8)
def _calls(recording: Recording) -> list[tuple[float, float]]:
    """Return when each call of predict returned [s], and its latency [ms], in that order.

    They are those that the judge had answered, so that only a node that asks has any.
    """
    found = [
        (call.answered / 1e9, call.took / 1e6)
        for call in recording.inferences
        if call.method == "predict" and not call.failed and call.asked >= 0
    ]
    return sorted(found, key=lambda call: call[0])  # of those that end together the first asked
