"""The oracle of trend_memory: what its contract asks for, from the recorded scans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from grader.checks.ahead import HAIR, HALF_ANGLES, front_distance
from grader.checks.contract import Contract, Limits, Survived, free_from
from grader.recording import Scan

MEMORY_SIZE = 10  # readings
LONGEST_GAP = 1.0  # [s] a stamp that jumps ahead by more empties the memory
STOP_DISTANCE = 0.5  # [m] nearer than this: stop
LEAST_TIME = 2.0  # [s] less than this to a collision: stop
SPEED = 0.3  # [m/s]
CLOSING_TOLERANCE = 1e-3  # [m/s]
_NEAR_THE_LIMIT = 0.005  # [m] |distance - 2 s · closing speed| for which both speeds are right

Readings = Sequence[tuple[float, float]]  # (stamp [s], distance [m])

CONTRACT = Contract(
    limits=Limits(fastest=0.3),
    free=free_from(0.65),
    patience=4.0,
    delayed_in=("trend_wall", "trend_cart"),
    survives=Survived(sensors=300, commands=300),
)


class Law(NamedTuple):
    """How a node makes a closing speed of the readings that it remembers."""

    name: str  # slope, or a mistake in it: see `closing_speed`
    scale: float = 1.0  # -1: the sign is forgotten; another one: another unit
    keeps: int | None = MEMORY_SIZE  # readings, the last ones; None: all that came
    first: bool = False  # it keeps the first ten instead
    counts: bool = False  # 0.1 s for each reading, whatever the stamps say
    grain: float = 0.0  # [m/s] to which it is rounded

    @property
    def tolerance(self) -> float:
        """How far a closing speed may be off, in the unit that the node has."""
        return CLOSING_TOLERANCE * abs(self.scale) + self.grain / 2


RIGHT = Law("slope")


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
    readings: tuple[tuple[float, float], ...]  # (stamp [s], distance [m]) since it was emptied
    speeds: frozenset[float]  # [m/s]

    @property
    def undefined(self) -> bool:
        """All stamps in the memory are equal: no line has a slope then, and nothing is asked."""
        stamps = {stamp for stamp, _ in self.readings[-MEMORY_SIZE:]}
        return len(self.readings) >= MEMORY_SIZE and len(stamps) == 1

    @property
    def silent(self) -> bool:
        """Nothing may be published on /closing_speed."""
        return not self.undefined and all(closing is None for closing in self.closings)

    @property
    def spoken(self) -> bool:
        """One closing speed has to be published."""
        return not self.undefined and all(closing is not None for closing in self.closings)

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
    law: Law
    early: bool
    last_stamp: float | None = None  # [s]

    def __post_init__(self) -> None:
        self.readings: list[tuple[float, float]] = []  # since it was emptied
        self.emptied = False
        self.distance: float | None = None

    def take(self, scan: Scan) -> float | None:
        """Take a scan in; return the closing speed [m/s] to decide by, if there is one."""
        stamp = math.floor(scan.stamp) if self.law.name == "whole seconds" else scan.stamp
        self.emptied = self.last_stamp is not None and not (
            0.0 <= stamp - self.last_stamp <= LONGEST_GAP
        )
        if self.emptied:
            self.readings.clear()
        self.last_stamp = stamp
        self.distance = front_distance(scan, self.half_angle)
        if self.distance is None or self.distance == math.inf:
            return None
        self.readings.append((scan.stamp, self.distance))
        if len(self.readings) < (2 if self.early else MEMORY_SIZE):
            return None
        return closing_speed(self.readings, self.law)


def steps(scans: tuple[Scan, ...], law: Law = RIGHT, *, early: bool = False) -> list[Step]:
    """Return what each scan of a run asks for.

    Or what it asks of a node that has another law, or speaks `early`: from the second reading on.
    """
    memories = [_Memory(angle, law, early) for angle in HALF_ANGLES]
    found = []
    for scan in scans:
        decided_by = [memory.take(scan) for memory in memories]
        speeds: set[float] = set()
        for memory, closing in zip(memories, decided_by, strict=True):
            speeds |= right_speeds(memory.distance, closing)
        closings = tuple(
            closing if len(memory.readings) >= MEMORY_SIZE else None
            for memory, closing in zip(memories, decided_by, strict=True)
        )
        here = memories[0]
        found.append(
            Step(
                scan,
                here.distance,
                min(len(here.readings), MEMORY_SIZE),
                here.emptied,
                closings,
                tuple(here.readings),
                frozenset(speeds),
            )
        )
    return found


def closing_speed(readings: Readings, law: Law = RIGHT) -> float:
    """Return minus the least-squares slope [m/s] of (stamp [s], distance [m]) pairs.

    Or what a node publishes that makes a mistake with them: `law` says which.
    """
    if law.first:
        readings = readings[:MEMORY_SIZE]
    elif law.keeps is not None:
        readings = readings[-law.keeps :]
    stamps = [stamp for stamp, _ in readings]
    distances = [distance for _, distance in readings]
    if law.counts:
        stamps = [0.1 * i for i in range(len(stamps))]
    if law.name == "first and last":
        return -law.scale * _ratio(distances[-1] - distances[0], stamps[-1] - stamps[0])
    if law.name == "time over distance":
        return -law.scale * _slope(distances, stamps)
    if law.name == "whole seconds":
        stamps = [math.floor(stamp) for stamp in stamps]
    return -law.scale * _slope(stamps, distances)


def _slope(x: Sequence[float], y: Sequence[float]) -> float:
    mean_x, mean_y = math.fsum(x) / len(x), math.fsum(y) / len(y)
    spread = math.fsum((value - mean_x) ** 2 for value in x)
    return _ratio(math.fsum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)), spread)


def _ratio(above: float, below: float) -> float:
    return above / below if below else 0.0


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
