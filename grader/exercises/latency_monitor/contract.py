"""The oracle of latency_monitor: the command for each scan, and the statistics of its calls."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from grader.checks.case import Case, Interval
from grader.checks.contract import Contract, Survived
from grader.checks.predictions import braking, model_found, model_says_go, speed_cases
from grader.recording import Recording

KEYS = ("count", "mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms", "deadline_ms", "missed")
LEVELS = ("OK", "WARN", "ERROR", "STALE")
OK, WARN, ERROR, STALE = range(4)
WINDOW = 100  # calls
DEADLINE = 100.0  # [ms] without the parameter
NEAR = 0.001  # [s] a call that ends this near to a report may count or not
MOST_CHOICES = 20  # calls that end so near to a report
OVERHEAD = 4.0  # [ms] that a call takes longer in real time: the link, waking up, Python's own

CONTRACT = Contract(
    free=model_says_go,
    nodes=(braking("slow", seconds=0.02),),
    delayed_in=("latency_wall",),
    survives=Survived(sensors=300, commands=300),
)


def cases(recording: Recording) -> list[Case]:
    """Return an occasion for each scan: the command is what the model predicts, clipped.

    What a report has to say: `grader.exercises.latency_monitor.reports.cases`.
    """
    return speed_cases(recording, model_found(recording.scenario))


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
        if not self.latencies:
            return STALE
        if self.numbers["p95_ms"] > self.deadline:
            return ERROR
        return WARN if self.numbers["missed"] else OK

    @property
    def levels(self) -> frozenset[str]:
        """The levels that are right, in words: more than one if calls may have taken longer."""
        least, most = self.level, self._latest.level
        return frozenset(LEVELS[least : most + 1])

    def span(self, key: str) -> Interval:
        """Return the least and the greatest right value of a key."""
        return self.numbers[key], self._latest.numbers[key]

    @cached_property
    def _latest(self) -> Statistics:
        if not self.late:
            return self
        return Statistics(tuple(latency + self.late for latency in self.latencies), self.deadline)


def right_statistics(recording: Recording, time: float) -> tuple[Statistics, ...]:
    """Return what a report may say at a time [s]: a call that ends just then may count or not.

    In real time each call may take longer.
    """
    overhead = 0.0 if recording.live is None else OVERHEAD
    soonest, latest = _calls(recording), _calls(recording, overhead / 1000.0)
    latencies = [call.latency for call in soonest]
    deadline = float(recording.scenario.node.parameters.get("deadline_ms", DEADLINE))
    near = NEAR + recording.slack
    least = bisect_right([call.end for call in latest], time - near)
    most = bisect_right([call.end for call in soonest], time + near)
    late = 1000.0 * recording.slack + overhead
    return tuple(
        _statistics(tuple(latencies[max(0, n - WINDOW) : n]), deadline, late)
        for n in range(max(least, most - MOST_CHOICES), most + 1)
    )


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
