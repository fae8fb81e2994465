"""The node's parameters, and the scenario that they lead to."""

import importlib.util
from dataclasses import dataclass
from typing import Any

import msgspec
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException

from sim.errors import InputError
from sim.lidar import PROFILES
from sim.live.options import Options
from sim.scenario import Scenario, Transforms
from sim.scenario_files import load_scenario

LIFE = 3600.0  # after this a robot that nobody stops starts over [s]: a scenario's maximum
RATES = 0.1, 10.0
SEEDS = 0, 2**53
DURATIONS = 0.0, LIFE
TIMEOUTS = 0.05, LIFE


@dataclass(frozen=True)
class Settings:
    """The values of the parameters."""

    scenario: Scenario  # with the lidar, seed, duration and command timeout they ask for
    rate: float  # scenario seconds in a second
    clock: bool  # send /clock
    wait: bool  # until somebody subscribes
    ends: bool  # after the scenario's duration; otherwise it starts over


def declare(node: Any, options: Options) -> Settings:
    """Declare the node's parameters with these defaults; return their values.

    Raises InputError: a value is not allowed, or there is no such scenario or lidar.
    """
    try:
        return _declare(node, options)
    except ParameterException as error:
        raise InputError(f"parameter: {error}") from None


def problem_with_rate(rate: float, *, clock: bool) -> str:
    """Say what is wrong with a rate that is within its range; empty if nothing is."""
    if rate != 1.0 and not clock:
        return (
            f"rate = {rate}: expected 1.0 without /clock, because stamps would leave today's time; "
            "start the robot with --clock (and the other nodes with use_sim_time:=true)"
        )
    return ""


def _declare(node: Any, options: Options) -> Settings:
    name = _fixed(node, "scenario", options.scenario, "a scenario's name, or its file")
    scenario = load_scenario(name)
    profiles = ", ".join(PROFILES)
    lidar = _fixed(
        node, "lidar", options.lidar or scenario.lidar.profile, f"lidar profile: {profiles}"
    )
    if lidar not in PROFILES:
        raise InputError(
            f"lidar = {lidar!r}: no lidar profile is called that; there is: {profiles}"
        )
    length = scenario.duration if options.once else options.duration or 0.0
    duration = _fixed(
        node,
        "duration",
        length,
        "how long the robot lives in scenario time [s]; 0: until it is stopped",
        DURATIONS,
    )
    timeout = _fixed(
        node,
        "command_timeout",
        scenario.robot.command_timeout,
        "how long a command stays in effect [s]; then the wheels ramp to zero",
        TIMEOUTS,
    )
    clock = _fixed(node, "clock", options.clock, "send /clock: all stamps are in simulated time")
    wait = _fixed(node, "wait", options.wait, "begin when somebody subscribes to the robot")
    seed = node.declare_parameter(
        "seed",
        scenario.seed if options.seed is None else options.seed,
        _describe("draws start, clutter and noise; a new one takes effect at /reset", SEEDS),
    ).value
    rate = node.declare_parameter(
        "rate",
        options.rate,
        _describe("scenario seconds in a second; not 1 only with clock", RATES),
    ).value
    if problem := problem_with_rate(rate, clock=clock):
        raise InputError(problem)
    changes: dict[str, Any] = {"seed": seed, "duration": duration or LIFE}
    changes["robot"] = msgspec.structs.replace(scenario.robot, command_timeout=timeout)
    # there is no wheel of tf2_msgs: without it the robot sends no transforms
    sends = importlib.util.find_spec("tf2_msgs") is not None and scenario.odometry.enabled
    changes["transforms"] = Transforms(enabled=sends)
    if lidar != scenario.lidar.profile:
        changes["lidar"] = msgspec.structs.replace(scenario.lidar, profile=lidar, rate=None)
    return Settings(
        scenario=msgspec.structs.replace(scenario, **changes),
        rate=rate,
        clock=clock,
        wait=wait,
        ends=duration > 0,
    )


def _fixed(
    node: Any, name: str, value: Any, text: str, limits: tuple[float, float] | None = None
) -> Any:
    """Declare a parameter that cannot be changed while the robot runs."""
    descriptor = _describe(text, limits)
    descriptor.read_only = True
    return node.declare_parameter(name, value, descriptor).value


def _describe(text: str, limits: tuple[float, float] | None) -> Any:
    descriptor = ParameterDescriptor(description=text)
    if limits is None:
        return descriptor
    low, high = limits
    if isinstance(low, int):
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high)]
    else:
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    return descriptor
