"""What happens in a run, and when: events, and the times of what comes at a rate."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from sim.faults import Times


class Kind(IntEnum):
    """What happens; at equal times the lower number comes first."""

    TELEPORT = 0
    GOAL = 1
    E_STOP = 2
    SCRIPTED_ODOM = 3
    SENSOR = 99  # minus the sensor's place in `sim.sensors.SENSORS`
    RAW = 100
    TRANSFORM = 101
    STATIC_TRANSFORM = 102


@dataclass(frozen=True, slots=True)
class Event:
    """One message or scripted event."""

    time: int  # when it is measured or done [ns]
    kind: int
    index: int  # of the script entry, or counted among those of its kind that arrive
    delivery: int  # when it arrives [ns]


def periodic(phase: float, rate: float, duration: float) -> Times:
    """Return the times of what comes at a rate [ns], each from its number, so that none drifts."""
    count = max(int((duration - phase) * rate) + 2, 0)
    return np.rint((phase + np.arange(count) / rate) * 1e9).astype(np.int64)
