"""When everything happens in a run: known from scenario and seed before it begins.

So the time of the next event is known without simulating up to it, and a run stays the same however
it is cut into pieces.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from sim.faults import Times, deliveries, sensor_rng, survivors
from sim.lidar import PROFILES
from sim.scenario import RawCommands, Scenario

STATIC_NS = 1_000_000  # when /tf_static is sent [ns]: before all sensors
RAW_STREAM = 1_000_000  # messages of a stream at most: 3600 s at 200 Hz are 720,000


class Kind(IntEnum):
    """What happens; at equal times the lower number comes first."""

    TELEPORT = 0
    GOAL = 1
    E_STOP = 2
    SCRIPTED_ODOM = 3
    ODOM = 4
    SCAN = 5
    RAW = 6
    TRANSFORM = 7
    STATIC_TRANSFORM = 8


@dataclass(frozen=True, slots=True)
class Event:
    """One message or scripted event."""

    time: int  # when it is measured or done [ns]
    kind: Kind
    index: int  # of the script entry, or counted among those of its kind that arrive
    delivery: int  # when it arrives [ns]


def schedule(scenario: Scenario, seed: int) -> list[Event]:
    """Return everything that arrives within the scenario's duration, by time of measurement."""
    events = _scripted(scenario)
    if scenario.odometry.enabled:
        events += _odometry(scenario, seed)
    if scenario.transforms.enabled:
        events += _transforms(events)
    if scenario.lidar.enabled:
        events += _scans(scenario, seed)
    for index, stream in enumerate(scenario.raw):
        events += _raw(stream, index)
    arriving = (event for event in events if event.delivery <= scenario.duration_ns)
    return sorted(arriving, key=lambda event: (event.time, event.kind, event.index))


def scan_rate(scenario: Scenario) -> float:
    """Return the lidar's scans per second [Hz]."""
    return scenario.lidar.rate or PROFILES[scenario.lidar.profile].rate


def _scripted(scenario: Scenario) -> list[Event]:
    events = []
    for index, entry in enumerate(scenario.script):
        time = round(entry.at * 1e9)
        kind = Kind.TELEPORT
        if entry.goal is not None:
            kind = Kind.GOAL
        elif entry.odom is not None:
            kind = Kind.SCRIPTED_ODOM
        elif entry.e_stop is not None:
            kind = Kind.E_STOP
        events.append(Event(time, kind, index, time))
    return events


def _raw(stream: RawCommands, index: int) -> list[Event]:
    """Return a stream's events; their index is that of the stream times `RAW_STREAM`, plus i."""
    times = _times(stream.begin, stream.rate, stream.end)
    times = times[times < round(stream.end * 1e9)]
    return [
        Event(time, Kind.RAW, index * RAW_STREAM + i, time) for i, time in enumerate(times.tolist())
    ]


def _odometry(scenario: Scenario, seed: int) -> list[Event]:
    spec, faults = scenario.odometry, scenario.faults
    rng = sensor_rng(seed, "odometry link")
    times = _times(spec.phase, spec.rate, scenario.duration)
    times = times[survivors(times, faults.odom_loss, rng, ())]
    return _events(Kind.ODOM, times, deliveries(times, faults.odom_latency, 0.0, rng))


def _transforms(odometry: list[Event]) -> list[Event]:
    """Return a transform with each message of the odometry, and the lidar's at the beginning."""
    moving = [
        Event(event.time, Kind.TRANSFORM, event.index, event.delivery)
        for event in odometry
        if event.kind is Kind.ODOM
    ]
    return [*moving, Event(STATIC_NS, Kind.STATIC_TRANSFORM, 0, STATIC_NS)]


def _scans(scenario: Scenario, seed: int) -> list[Event]:
    faults = scenario.faults
    rng = sensor_rng(seed, "lidar link")
    times = _times(scenario.lidar.phase, scan_rate(scenario), scenario.duration)
    times = times[survivors(times, faults.scan_loss, rng, faults.blackout)]
    if scenario.bench:
        times = times[: len(scenario.bench_scans)]
    late = deliveries(times, faults.scan_latency, faults.scan_jitter, rng)
    return _events(Kind.SCAN, times, late)


def _times(phase: float, rate: float, duration: float) -> Times:
    """Return the times of a periodic sensor [ns], each from its number, so that none drifts."""
    count = max(int((duration - phase) * rate) + 2, 0)
    return np.rint((phase + np.arange(count) / rate) * 1e9).astype(np.int64)


def _events(kind: Kind, times: Times, late: Times) -> list[Event]:
    pairs = zip(times.tolist(), late.tolist(), strict=True)
    return [Event(time, kind, index, delivery) for index, (time, delivery) in enumerate(pairs)]
