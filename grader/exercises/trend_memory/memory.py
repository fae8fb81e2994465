"""The memory of trend_memory: what each scan asks for, wherever the contract leaves room."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from statistics import StatisticsError, linear_regression

from grader.checks.ahead import HAIR, HALF_ANGLES, front_distance
from grader.recording import Scan

SIZE = 10  # readings
LONGEST_GAP = 1.0  # [s] a stamp that jumps ahead by more empties the memory
STOP_DISTANCE = 0.5  # [m] nearer than this: stop
LEAST_TIME = 2.0  # [s] less than this to a collision: stop
SPEED = 0.3  # [m/s]
NEAR_THE_LIMIT = 0.005  # [m] |distance - 2 s · closing speed| for which both speeds are right

Reading = tuple[float, float]  # (stamp [s], distance [m])


@dataclass(frozen=True)
class Step:
    """What one scan asks for.

    Beams near the sector's edge may count or not, and a gap is one between two scans or between two
    readings, so there may be several right answers.
    """

    remembered: bool  # the scan has a reading
    count: int  # readings since the memory was last emptied
    forgotten: bool  # a stamp emptied the memory, and it isn't full again
    closings: tuple[float | None, ...]  # [m/s] for each way to remember; None: publish nothing
    speeds: frozenset[float]  # [m/s]

    @property
    def due(self) -> bool | None:
        """Whether one closing speed has to be published, or none may; None: either is right."""
        numbers = [closing for closing in self.closings if closing is not None]
        if not numbers:
            return False
        agreed = len(numbers) == len(self.closings) and all(map(math.isfinite, numbers))
        return True if agreed else None


@dataclass
class _Memory:
    """An agent's memory; `by_scan`: a gap is one between two scans, else between two readings."""

    half_angle: float  # [°] where its front sector ends
    by_scan: bool
    readings: list[Reading] = field(default_factory=list)  # since it was emptied
    emptied: bool = False
    last_stamp: float | None = None  # [s]

    def take(self, scan: Scan) -> tuple[float | None, float | None]:
        """Take a scan in; return its distance [m], and the closing speed [m/s], if there is one."""
        distance = front_distance(scan, self.half_angle)
        if self.by_scan or _is_reading(distance):
            gap = 0.0 if self.last_stamp is None else scan.stamp - self.last_stamp
            if not 0.0 <= gap <= LONGEST_GAP:
                self.readings, self.emptied = [], True
            self.last_stamp = scan.stamp
        if distance is None or not _is_reading(distance):
            return distance, None
        self.readings.append((scan.stamp, distance))
        full = len(self.readings) >= SIZE
        return distance, closing_speed(self.readings[-SIZE:]) if full else None


def steps(scans: Iterable[Scan]) -> list[Step]:
    """Return what each scan of a run asks for."""
    memories = [_Memory(angle, by_scan) for by_scan in (True, False) for angle in HALF_ANGLES]
    found = []
    for scan in scans:
        seen = [memory.take(scan) for memory in memories]
        here, remembered = memories[0], _is_reading(seen[0][0])
        found.append(
            Step(
                remembered=remembered,
                count=len(here.readings),
                forgotten=here.emptied and remembered and len(here.readings) < SIZE,
                closings=tuple(closing for _, closing in seen),
                speeds=frozenset().union(*(right_speeds(*each) for each in seen)),
            )
        )
    return found


def closing_speed(readings: Sequence[Reading]) -> float:
    """Return minus the least-squares slope of distance over stamp [m/s]; NaN: there is none."""
    try:
        return -linear_regression(*zip(*readings, strict=True)).slope
    except StatisticsError:  # all stamps are equal
        return math.nan


def right_speeds(distance: float | None, closing: float | None) -> set[float]:
    """Return the forward speeds [m/s] that are right; both where a limit is too near to tell."""
    if distance is None:
        return {0.0}
    if distance == math.inf:
        return {SPEED}
    speeds = {0.0 if distance < STOP_DISTANCE else SPEED}
    if 0.0 < abs(distance - STOP_DISTANCE) < HAIR:
        speeds = {0.0, SPEED}
    if closing is None or not closing > 0.0:
        return speeds
    spare = distance - LEAST_TIME * closing
    if abs(spare) <= NEAR_THE_LIMIT:
        return speeds | {0.0}
    return {0.0} if spare < 0.0 else speeds


def _is_reading(distance: float | None) -> bool:
    return distance is not None and distance < math.inf
