"""The real thing for tests: a way to run a few lines of node."""

import textwrap
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from grader.course.submission import Submission
from grader.link.hosts import ForkServer
from grader.recording import Recording
from grader.trial.virtual_time import Limits, run_trial
from sim.scenario import Scenario, load_scenario

PREAMBLE = """\
import os, sys, threading, time
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

class Echo(Node):
    '''One Twist per scan.'''
    def __init__(self, name='echo', **groups):
        super().__init__(name)
        self.publisher = self.create_publisher(Twist, '/cmd_vel', 10)
        self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
    def on_scan(self, scan):
        self.publisher.publish(Twist())
"""

RunNode = Callable[..., Recording]


@pytest.fixture(scope="session")
def short_scenario() -> Scenario:
    """Two seconds of a lidar at 10 Hz; no odometry."""
    return short(2.0)


def short(duration: float, name: str = "demo_wall") -> Scenario:
    scenario = load_scenario(name)
    odometry = msgspec.structs.replace(scenario.odometry, enabled=False)
    return msgspec.structs.replace(scenario, duration=duration, odometry=odometry)


@pytest.fixture
def run_node(forkserver: ForkServer, short_scenario: Scenario, tmp_path: Path) -> RunNode:
    """Run a few lines of node (after PREAMBLE) in a scenario."""

    def run(source: str | bytes, scenario: Scenario | None = None, **options: object) -> Recording:
        file = tmp_path / "node.py"
        if isinstance(source, str):
            source = (PREAMBLE + textwrap.dedent(source)).encode()
        file.write_bytes(source)
        options.setdefault("limits", Limits(start=20.0, step=5.0, total=60.0))
        return run_trial(Submission(file), scenario or short_scenario, forkserver, **options)

    return run
