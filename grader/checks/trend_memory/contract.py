"""The oracle of trend_memory: what its contract asks for, from the recorded scans."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from grader.checks.ahead import HAIR, HALF_ANGLES, front_distance
from grader.recording import Scan

MEMORY_SIZE = 10  # readings
LONGEST_GAP = 1.0  # [s] a stamp that jumps ahead by more empties the memory
STOP_DISTANCE = 0.5  # [m] nearer than this: stop
LEAST_TIME = 2.0  # [s] less than this to a collision: stop
SPEED = 0.3  # [m/s]
CLOSING_TOLERANCE = 1e-3  # [m/s]
_NEAR_THE_LIMIT = 0.005  # [m] |distance - 2 s · closing speed| for which both speeds are right


@dataclass(frozen=True)
class Step:
    """What one scan asks for.

    Beams near the sector's edge may count or not, so there may be several right answers.
    """

    scan: Scan
    distance: float | None  # [m] ahead; inf: nothing within range, None: blind
    known: int  # readings in the memory after this scan
    emptied: bool  # the stamp emptied the memory
    closings: tuple[float | None, ...]  # [m/s] for each half-angle; None: publish nothing
    speeds: frozenset[float]  # [m/s]

    @property
    def silent(self) -> bool:
        """Nothing may be published on /closing_speed."""
        return all(closing is None for closing in self.closings)

    @property
    def spoken(self) -> bool:
        """One closing speed has to be published."""
        return all(closing is not None for closing in self.closings)

    @property
    def remembered(self) -> bool:
        """The scan has a reading to remember."""
        return self.distance is not None and self.distance < math.inf

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the greatest right closing speed [m/s]."""
        known = [closing for closing in self.closings if closing is not None]
        return min(known), max(known)


@dataclass
class _Memory:
    """The agent's memory, if its front sector ends at this half-angle."""

    half_angle: float  # [°]
    last_stamp: float | None = None  # [s]

    def __post_init__(self) -> None:
        self.readings: deque[tuple[float, float]] = deque(maxlen=MEMORY_SIZE)
        self.emptied = False
        self.distance: float | None = None

    def take(self, scan: Scan) -> float | None:
        """Take a scan in; return the closing speed [m/s], if one has to be published."""
        self.emptied = self.last_stamp is not None and not (
            0.0 <= scan.stamp - self.last_stamp <= LONGEST_GAP
        )
        if self.emptied:
            self.readings.clear()
        self.last_stamp = scan.stamp
        self.distance = front_distance(scan, self.half_angle)
        if self.distance is None or self.distance == math.inf:
            return None
        self.readings.append((scan.stamp, self.distance))
        return closing_speed(self.readings) if len(self.readings) == MEMORY_SIZE else None


def steps(scans: tuple[Scan, ...]) -> list[Step]:
    """Return what each scan of a run asks for."""
    memories = [_Memory(angle) for angle in HALF_ANGLES]
    found = []
    for scan in scans:
        closings = tuple(memory.take(scan) for memory in memories)
        speeds: set[float] = set()
        for memory, closing in zip(memories, closings, strict=True):
            speeds |= right_speeds(memory.distance, closing)
        here = memories[0]
        found.append(
            Step(scan, here.distance, len(here.readings), here.emptied, closings, frozenset(speeds))
        )
    return found


def closing_speed(readings: deque[tuple[float, float]]) -> float:
    """Return minus the least-squares slope [m/s] of (stamp [s], distance [m]) pairs."""
    n = len(readings)
    mean_stamp = math.fsum(stamp for stamp, _ in readings) / n
    mean_distance = math.fsum(distance for _, distance in readings) / n
    spread = math.fsum((stamp - mean_stamp) ** 2 for stamp, _ in readings)
    shared = math.fsum((t - mean_stamp) * (d - mean_distance) for t, d in readings)
    return -shared / spread


def right_speeds(distance: float | None, closing: float | None) -> set[float]:
    """Return the forward speeds [m/s] that are right; both where a limit is too near to tell."""
    if distance is None:
        return {0.0}
    if distance == math.inf:
        return {SPEED}
    speeds = {0.0 if distance < STOP_DISTANCE else SPEED}
    if 0.0 < abs(distance - STOP_DISTANCE) < HAIR:
        speeds = {0.0, SPEED}
    if closing is None or closing <= 0.0:
        return speeds
    spare = distance - LEAST_TIME * closing
    if abs(spare) <= _NEAR_THE_LIMIT:
        return speeds | {0.0}
    return {0.0} if spare < 0.0 else speeds
