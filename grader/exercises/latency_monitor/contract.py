"""The oracle of latency_monitor: which calls of predict have ended when, and their statistics."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from grader.checks.braking import braking, model_says_go
from grader.checks.contract import Contract, Survived
from grader.recording import Recording

TOPIC = "/diagnostics"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
STATUS_NAME = "profiled_controller: inference"
KEYS = ("count", "mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms", "deadline_ms", "missed")
LATENCIES = ("mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms")
OK, WARN, ERROR, STALE = range(4)
LEVELS = ("OK", "WARN", "ERROR", "STALE")
WINDOW = 100  # calls
EVERYTHING = 10**9  # calls
DEADLINE = 100.0  # [ms] without the parameter
PERIOD = 1.0  # [s] of the reports
PERIOD_TOLERANCE = 0.15  # [s]
MOST_CHOICES = 20  # calls that end within a hair of a report and may count or not
FEW_CHOICES = 3  # the same at the report before, if that empties the window
HAIR = 0.001  # [s] a call that ends this near to a report may count or not
TOLERANCE = 0.1  # [ms]; "12.3" is a fine way to write 12.345
THREE_DIGITS = 0.0006  # what rounding to three digits may change, in any unit
OVERHEAD = 4.0  # [ms] that a call takes longer in real time: the link, waking up, Python's own

CONTRACT = Contract(
    free=model_says_go,
    nodes=(braking("slow", seconds=0.02),),
    delayed_in=("latency_wall",),
    survives=Survived(sensors=300, commands=300),
)


@dataclass(frozen=True)
class Statistics:
    """What a report has to say about a window of calls."""

    latencies: tuple[float, ...]  # [ms]
    deadline: float  # [ms]
    late: float = 0.0  # [ms] that each call may have taken longer, in real time

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The eight values."""
        found = self.latencies
        p50, p95, p99 = np.percentile(found, (50, 95, 99)) if found else (0.0,) * 3
        return {
            "count": len(found),
            "mean_ms": float(np.mean(found)) if found else 0.0,
            "p50_ms": float(p50),
            "p95_ms": float(p95),
            "p99_ms": float(p99),
            "max_ms": max(found, default=0.0),
            "deadline_ms": self.deadline,
            "missed": sum(latency > self.deadline for latency in found),
        }

    @property
    def level(self) -> int:
        """The level: STALE, OK, WARN or ERROR."""
        numbers = self.numbers
        if not self.latencies:
            return STALE
        if numbers["p95_ms"] > self.deadline:
            return ERROR
        return WARN if numbers["missed"] else OK

    @property
    def levels(self) -> frozenset[int]:
        """The levels that are right: more than one if calls may have taken longer."""
        least, most = self.level, self._latest.level
        return frozenset({least, most} if least == STALE else range(least, most + 1))

    def allows(self, key: str, number: float, scale: float = 1.0) -> bool:
        """Tell whether this is the value of a key; `scale`: of a latency in another unit."""
        least, most = self.numbers[key], self._latest.numbers[key]
        if scale == 1.0 or key not in LATENCIES:
            return least - TOLERANCE <= number <= most + TOLERANCE
        tolerance = max(scale * TOLERANCE, THREE_DIGITS)
        return scale * least - tolerance <= number <= scale * most + tolerance

    @cached_property
    def _latest(self) -> Statistics:
        if not self.late:
            return self
        return Statistics(tuple(latency + self.late for latency in self.latencies), self.deadline)


def right_statistics(
    recording: Recording, time: float, window: int = WINDOW, since: float = -math.inf
) -> tuple[Statistics, ...]:
    """Return what a report may say at a time [s]: a call that ends just then may count or not.

    In real time each call may take longer. Calls that ended before `since` [s] do not count.
    """
    overhead = 0.0 if recording.live is None else OVERHEAD
    soonest, latest = _calls(recording), _calls(recording, overhead / 1000.0)
    latencies = [call.latency for call in soonest]
    deadline = deadline_of(recording)
    near = HAIR + recording.slack
    least = bisect_right([call.end for call in latest], time - near)
    most = bisect_right([call.end for call in soonest], time + near)
    first = bisect_right([call.end for call in latest], since - near)
    last = bisect_right([call.end for call in soonest], since + near)
    late = 1000.0 * recording.slack + overhead
    return tuple(
        _statistics(tuple(latencies[max(begin, n - window) : n]), deadline, late)
        for n in range(max(least, most - MOST_CHOICES), most + 1)
        for begin in range(max(first, last - FEW_CHOICES), last + 1)
    )


def deadline_of(recording: Recording) -> float:
    """Return the parameter deadline_ms that the node was given [ms]."""
    return float(recording.scenario.node.parameters.get("deadline_ms", DEADLINE))


def calls_by(recording: Recording, time: float) -> int:
    """Return how many calls may have ended by a time [s]."""
    return bisect_right([call.end for call in _calls(recording)], time + HAIR + recording.slack)


@lru_cache(maxsize=4096)  # a node may report very often
def _statistics(latencies: tuple[float, ...], deadline: float, late: float) -> Statistics:
    return Statistics(latencies, deadline, late)


class _Call(NamedTuple):
    """A call of predict that returned."""

    end: float  # [s]
    latency: float  # [ms]


@lru_cache(maxsize=8)
def _calls(recording: Recording, overhead: float = 0.0) -> list[_Call]:
    """Return the calls in order of their end, as if each took longer by the overhead [s].

    They are those that the judge had answered, so that only a node that asks has any.
    """
    found = [
        _Call(call.answered / 1e9 + overhead, call.took / 1e6)
        for call in recording.inferences
        if call.method == "predict" and not call.failed and call.asked >= 0
    ]
    return sorted(found, key=lambda call: call.end)  # of those that end together the first asked
