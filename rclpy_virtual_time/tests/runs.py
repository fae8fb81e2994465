"""What the tests of hosts share: a small node, and a lidar that speaks at 10 Hz."""

import os
import select
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from rclpy_virtual_time import Delivery, Discovery, Launcher, Offer, ProgramStart
from rclpy_virtual_time.link.programs import ProgramsRun, run_programs
from rclpy_virtual_time.link.settings import EPOCH

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
LIDAR = Offer("/scan", "sensor_msgs/msg/LaserScan", reliable=True)
MS = 10**6  # [ns]
# measured between two processes on plain rclpy, on one machine: 100 of each
DISCOVERY = Discovery((90 * MS, 130 * MS), 0.08, (MS // 2, 18 * MS), (19 * MS // 2, 20 * MS))

RunNode = Callable[..., ProgramsRun]


@cache
def messages() -> Any:
    """ROS's messages without ROS, which stays out of this process."""
    return get_typestore(Stores.ROS2_JAZZY)


def scans(until: int) -> Iterator[tuple[int, Delivery]]:
    """Yield what a lidar says, and when it arrives: 13 ms after its stamp."""
    types, ranges = messages().types, np.array([3.0], np.float32)
    for time in range(0, until - 13 * MS, 100 * MS):
        stamp = types["builtin_interfaces/msg/Time"](*divmod(EPOCH + time, 10**9))
        header = types["std_msgs/msg/Header"](stamp, "base_scan")
        scan = types[LIDAR.type](header, *[0.0] * 7, ranges, ranges[:0])
        data = bytes(messages().serialize_cdr(scan, LIDAR.type))
        yield time + 13 * MS, Delivery("/scan", data)


def run_beside_lidar(
    launcher: Launcher,
    folder: Path,
    *programs: str | ProgramStart,
    seconds: float = 2.0,
    arguments: tuple[str, ...] = (),
    **options: Any,
) -> ProgramsRun:
    """Run programs of a folder beside a lidar, by their files."""
    until = round(seconds * 1e9)
    starts = [ProgramStart(p, arguments) if isinstance(p, str) else p for p in programs]
    settings = {"offers": [LIDAR], "deliveries": scans(until), "discovery": DISCOVERY} | options
    return run_programs(launcher, folder, starts, until=until, **settings)


def end_of(run: ProgramsRun) -> str:
    """Say how a run ended: "completed", or as its `Ended` has it, or as what did not go on."""
    if run.ended:
        return run.ended.kind
    return "never_spun" if not run.spun else "completed" if run.stuck is None else "stuck"


def said(run: ProgramsRun) -> list[str]:
    """Return the lines of stdout."""
    return [line.text for line in run.log if line.level == "stdout"]


def times(run: ProgramsRun, topic: str) -> NDArray[np.float64]:
    """Return when programs published on a topic [s]."""
    return np.array([m.time for m in run.published if m.topic == topic]) / 1e9


def sent(run: ProgramsRun, topic: str) -> list[Any]:
    """Return what programs published on a topic."""
    said = [m for m in run.published if m.topic == topic]
    return [messages().deserialize_cdr(m.data, m.type) for m in said]


def is_over(handle: int) -> bool:
    """Wait for the end of the process that a pidfd stands for."""
    poll = select.poll()
    poll.register(handle, select.POLLIN)
    over = bool(poll.poll(20_000))  # [ms]
    os.close(handle)
    return over
