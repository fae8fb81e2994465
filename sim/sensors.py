"""The robot's sensors: one table for schedule, simulation, live robot and hosts."""

from typing import Protocol

from sim.events import Event, Kind
from sim.faults import Times
from sim.layout import Layout, Pose
from sim.messages import (
    BOOL,
    CMD_VEL_RAW_TOPIC,
    E_STOP_TOPIC,
    GOAL_TOPIC,
    POSE_STAMPED,
    TF_MESSAGE,
    TF_STATIC_TOPIC,
    TF_TOPIC,
    TWIST,
    Message,
)
from sim.odometry import Odometry
from sim.scanner import Scanner
from sim.scenario import Scenario


class Sensor(Protocol):
    """What measures at a rate of its own; one is made for each run."""

    topic: str
    type: str
    table: str  # of a scenario: its settings, with `enabled` and `phase`

    def __init__(self, scenario: Scenario, layout: Layout, seed: int) -> None: ...

    @staticmethod
    def rate(scenario: Scenario) -> float:
        """Return its messages per second [Hz]."""

    @staticmethod
    def arrivals(scenario: Scenario, seed: int) -> tuple[Times, Times]:
        """Return when the messages that arrive are measured, and when they arrive [ns]."""

    def message(self, event: Event, pose: Pose, speeds: tuple[float, float]) -> Message:
        """Return the message of this event: true pose [m, m, rad] and speeds [m/s, rad/s]."""


# Where several measure at the same time, the last of them comes first
SENSORS: tuple[type[Sensor], ...] = (Scanner, Odometry)
SENSOR_TOPICS = frozenset(sensor.topic for sensor in SENSORS)  # those of `[qos] sensors`
OFFERED = {  # what a scenario can have the robot send: topic → type
    **{sensor.topic: sensor.type for sensor in SENSORS},
    GOAL_TOPIC: POSE_STAMPED,
    CMD_VEL_RAW_TOPIC: TWIST,
    E_STOP_TOPIC: BOOL,
    TF_TOPIC: TF_MESSAGE,
    TF_STATIC_TOPIC: TF_MESSAGE,
}

TOPIC_OF: dict[int, str] = {  # of what happens, by its kind
    **{Kind.SENSOR - place: sensor.topic for place, sensor in enumerate(SENSORS)},
    Kind.SCRIPTED_ODOM: Odometry.topic,
    Kind.GOAL: GOAL_TOPIC,
    Kind.RAW: CMD_VEL_RAW_TOPIC,
    Kind.E_STOP: E_STOP_TOPIC,
    Kind.TRANSFORM: TF_TOPIC,
    Kind.STATIC_TRANSFORM: TF_STATIC_TOPIC,
}


def enabled_sensors(scenario: Scenario) -> dict[int, type[Sensor]]:
    """Return the sensors that a scenario's robot has, by their place in the table."""
    return {
        place: sensor
        for place, sensor in enumerate(SENSORS)
        if getattr(scenario, sensor.table).enabled
    }
