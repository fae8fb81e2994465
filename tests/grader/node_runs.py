"""What the tests of hosts and trials share: a small node, a short scenario."""

import os
import select
from collections.abc import Callable

import msgspec

from grader.recording import Recording
from sim.scenario import Scenario
from sim.scenario_files import load_scenario

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


def short(duration: float, name: str = "demo_wall") -> Scenario:
    scenario = load_scenario(name)
    odometry = msgspec.structs.replace(scenario.odometry, enabled=False)
    return msgspec.structs.replace(scenario, duration=duration, odometry=odometry)


def is_over(handle: int) -> bool:
    """Wait for the end of the process that a pidfd stands for."""
    poll = select.poll()
    poll.register(handle, select.POLLIN)
    over = bool(poll.poll(20_000))  # [ms]
    os.close(handle)
    return over
