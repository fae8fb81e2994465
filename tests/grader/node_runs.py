"""What the tests of hosts and trials share: a small node, a short scenario."""

from collections.abc import Callable

import msgspec

from grader.recording import Recording
from rclpy_virtual_time.tests.runs import PREAMBLE
from sim.scenario import Scenario
from sim.scenario_files import load_scenario

__all__ = ["PREAMBLE", "RunNode", "short"]

RunNode = Callable[..., Recording]


def short(duration: float, name: str = "demo_wall") -> Scenario:
    scenario = load_scenario(name)
    odometry = msgspec.structs.replace(scenario.odometry, enabled=False)
    return msgspec.structs.replace(scenario, duration=duration, odometry=odometry)
