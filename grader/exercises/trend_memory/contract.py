"""The contract of trend_memory: what each scan asks for, wherever it leaves room."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from statistics import StatisticsError, linear_regression

import numpy as np

from grader.checks.ahead import HAIR, HALF_ANGLES, front_distance
from grader.checks.case import Case, answered, exactly
from grader.checks.commands import Answer, answers, published
from grader.checks.contract import RACE, Contract, Limits, free_from
from grader.recording import Recording, Scan
from sim.messages import FLOAT64

TOPIC = "/closing_speed"
SIZE = 10  # readings
LONGEST_GAP = 1.0  # [s] a stamp that jumps ahead by more empties the memory
STOP_DISTANCE = 0.5  # [m] nearer than this: stop
LEAST_TIME = 2.0  # [s] less than this to a collision: stop
SPEED = 0.3  # [m/s]
NEAR_THE_LIMIT = 0.005  # [m] |distance - 2 s · closing speed| for which both speeds are right

Reading = tuple[float, float]  # (stamp [s], distance [m])

CONTRACT = Contract(limits=Limits(fastest=0.3), free=free_from(0.65), patience=4.0, race=RACE)


def cases(recording: Recording) -> list[Case]:
    """Return the occasions of each scan: its command, how many closing speeds come, and which.

    The others are missing where the contract leaves open whether a closing speed comes.
    """
    found, said = answers(recording), published(recording, TOPIC, FLOAT64)
    begins = [*(answer.scan.t for answer in found), math.inf]
    bounds = np.searchsorted([time for time, _ in said], begins)
    occasions = []
    for i, step in enumerate(steps([answer.scan for answer in found])):
        occasions.append(_command(found[i], step))
        if step.due is not None:
            values = [float(value.data) for _, value in said[bounds[i] : bounds[i + 1]]]
            what = f"scan {i + 1} ({found[i].what})"
            occasions += _closing_speeds(found[i].scan.t, what, step, values)
    return occasions


def _command(answer: Answer, step: Step) -> Case:
    what, closing = answer.what, step.closings[0]
    if closing and closing > 0.0:
        what += f", which comes closer at {closing:.2f} m/s"
    tags = ("command", "forgotten") if step.forgotten else ("command",)
    return answered(answer, {"linear.x": exactly(*step.speeds)}, *tags, what=what)


def _closing_speeds(at: float, what: str, step: Step, values: Sequence[float]) -> Iterator[Case]:
    """Yield how many come, one or none (`pace`), and what the one is."""
    if not step.remembered:
        what += ", which is not remembered"
    elif not step.due:
        what += f", reading {step.count} of {SIZE}"
    due = "due" if step.due else "filling" if step.remembered else "not_due"
    right, count = {"count": frozenset({"1" if step.due else "0"})}, {"count": str(len(values))}
    yield Case(at, what, frozenset({"pace", due}), right, count)
    if step.due:
        numbers = [closing for closing in step.closings if closing is not None]
        tags = frozenset({"full", "tenth"} if step.count == SIZE else {"full"})
        speed = {"data": ((min(numbers), max(numbers)),)}
        yield Case(at, what, tags, speed, {"data": values[-1]} if values else {})


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
