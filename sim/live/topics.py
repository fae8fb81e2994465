"""Which topics a scenario's robot sends, and how often."""

from sim.messages import (
    CMD_VEL_RAW_TOPIC,
    E_STOP_TOPIC,
    GOAL_TOPIC,
    ODOM_TOPIC,
    TF_STATIC_TOPIC,
    TF_TOPIC,
)
from sim.scenario import Scenario
from sim.sensors import enabled_sensors

NOW_AND_THEN = 0.0  # the nominal rate of what comes with another message or by the script [Hz]


def sent_topics(scenario: Scenario) -> dict[str, float]:
    """Return the topics that this scenario's robot sends: topic → nominal rate [Hz].

    A topic that it never sends does not exist, as on a robot that lacks the sensor.
    """
    sensors = enabled_sensors(scenario).values()
    rates = {sensor.topic: sensor.rate(scenario) for sensor in sensors}
    if any(event.odom is not None for event in scenario.script):
        rates.setdefault(ODOM_TOPIC, NOW_AND_THEN)
    if any(event.goal is not None for event in scenario.script):
        rates[GOAL_TOPIC] = NOW_AND_THEN
    if any(event.e_stop is not None for event in scenario.script):
        rates[E_STOP_TOPIC] = NOW_AND_THEN
    if scenario.raw:
        rates[CMD_VEL_RAW_TOPIC] = NOW_AND_THEN
    if scenario.transforms.enabled:
        rates |= {TF_TOPIC: NOW_AND_THEN, TF_STATIC_TOPIC: NOW_AND_THEN}
    return rates


def patience(rates: dict[str, float]) -> float:
    """Return how late the robot may be before its time slips [s]: 2 periods of its fastest sensor.

    So it never catches up on more than two messages of a sensor. At least 50 ms, by which a busy
    operating system delays a process; 0.1 s if there is no sensor.
    """
    fastest = max(rates.values(), default=NOW_AND_THEN)
    return 0.1 if fastest == NOW_AND_THEN else max(0.05, 2.0 / fastest)
