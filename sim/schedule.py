"""When everything happens in a run: known from scenario and seed before it begins.

So the time of the next event is known without simulating up to it, and a run stays the same however
it is cut into pieces.
"""

from sim.events import Event, Kind, periodic
from sim.odometry import Odometry
from sim.scenario import RawCommands, Scenario
from sim.sensors import SENSORS, enabled_sensors

STATIC_NS = 1_000_000  # when /tf_static is sent [ns]: before all sensors
RAW_STREAM = 1_000_000  # messages of a stream at most: 3600 s at 200 Hz are 720,000
ODOM = Kind.SENSOR - SENSORS.index(Odometry)


def schedule(scenario: Scenario, seed: int) -> list[Event]:
    """Return everything that arrives within the scenario's duration, by time of measurement."""
    events = _scripted(scenario)
    for place, sensor in enabled_sensors(scenario).items():
        times, late = (part.tolist() for part in sensor.arrivals(scenario, seed))
        pairs = enumerate(zip(times, late, strict=True))
        events += [Event(time, Kind.SENSOR - place, index, at) for index, (time, at) in pairs]
    if scenario.transforms.enabled:
        events += _transforms(events)
    for index, stream in enumerate(scenario.raw):
        events += _raw(stream, index)
    arriving = (event for event in events if event.delivery <= scenario.duration_ns)
    return sorted(arriving, key=lambda event: (event.time, event.kind, event.index))


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
    times = periodic(stream.begin, stream.rate, stream.end)
    times = times[times < round(stream.end * 1e9)]
    return [
        Event(time, Kind.RAW, index * RAW_STREAM + i, time) for i, time in enumerate(times.tolist())
    ]


def _transforms(events: list[Event]) -> list[Event]:
    """Return a transform with each message of the odometry, and the lidar's at the beginning."""
    moving = [
        Event(event.time, Kind.TRANSFORM, event.index, event.delivery)
        for event in events
        if event.kind == ODOM
    ]
    return [*moving, Event(STATIC_NS, Kind.STATIC_TRANSFORM, 0, STATIC_NS)]
