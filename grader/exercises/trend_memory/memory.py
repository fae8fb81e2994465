"""The memory of trend_memory: what each scan asks for, wherever the contract leaves room."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

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

    distance: float | None  # [m] ahead; inf: nothing within range, None: blind
    count: int  # readings since the memory was last emptied
    forgotten: bool  # a stamp emptied the memory, and it isn't full again
    open: bool  # all stamps in the memory are equal: no line has a slope, and nothing is asked
    closings: tuple[float | None, ...]  # [m/s] for each way to remember; None: publish nothing
    speeds: frozenset[float]  # [m/s]

    @property
    def remembered(self) -> bool:
        """The scan has a reading to remember."""
        return is_reading(self.distance)

    @property
    def silent(self) -> bool:
        """Nothing may be published on /closing_speed."""
        return not self.open and all(closing is None for closing in self.closings)

    @property
    def full(self) -> bool:
        """One closing speed has to be published."""
        return not self.open and all(closing is not None for closing in self.closings)


@dataclass
class _Memory:
    """An agent's memory; `by_scan`: a gap is one between two scans, else between two readings."""

    half_angle: float  # [°] where its front sector ends
    by_scan: bool
    readings: deque[Reading] = field(default_factory=lambda: deque(maxlen=SIZE))
    last_stamp: float | None = None  # [s]
    count: int = 0  # readings since it was emptied
    emptied: bool = False
    distance: float | None = None  # [m] of the last scan

    def take(self, scan: Scan) -> float | None:
        """Take a scan in; return the closing speed [m/s], if there is one."""
        self.distance = front_distance(scan, self.half_angle)
        if self.by_scan or is_reading(self.distance):
            self._compare(scan.stamp)
        if self.distance is None or not is_reading(self.distance):
            return None
        self.count += 1
        self.readings.append((scan.stamp, self.distance))
        return closing_speed(self.readings) if len(self.readings) == SIZE else None

    def _compare(self, stamp: float) -> None:
        if self.last_stamp is not None and not 0.0 <= stamp - self.last_stamp <= LONGEST_GAP:
            self.readings.clear()
            self.count, self.emptied = 0, True
        self.last_stamp = stamp


def steps(scans: Iterable[Scan]) -> list[Step]:
    """Return what each scan of a run asks for."""
    memories = [_Memory(angle, by_scan) for by_scan in (True, False) for angle in HALF_ANGLES]
    here, found = memories[0], []
    for scan in scans:
        closings = tuple(memory.take(scan) for memory in memories)
        full = len(here.readings) == SIZE
        found.append(
            Step(
                distance=here.distance,
                count=here.count,
                forgotten=here.emptied and not full and is_reading(here.distance),
                open=full and len({stamp for stamp, _ in here.readings}) == 1,
                closings=closings,
                speeds=frozenset().union(
                    *(
                        right_speeds(memory.distance, closing)
                        for memory, closing in zip(memories, closings, strict=True)
                    )
                ),
            )
        )
    return found


def is_reading(distance: float | None) -> bool:
    """Return whether a distance [m] is remembered."""
    return distance is not None and distance < math.inf


def closing_speed(readings: Sequence[Reading]) -> float:
    """Return minus the least-squares slope of distance over stamp [m/s]; 0.0: there is none."""
    stamps, distances = zip(*readings, strict=True)
    mean_stamp, mean_distance = math.fsum(stamps) / len(stamps), math.fsum(distances) / len(stamps)
    spread = math.fsum((stamp - mean_stamp) ** 2 for stamp in stamps)
    common = math.fsum((t - mean_stamp) * (d - mean_distance) for t, d in readings)
    return -common / spread if spread else 0.0


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
    if abs(spare) <= NEAR_THE_LIMIT:
        return speeds | {0.0}
    return {0.0} if spare < 0.0 else speeds
