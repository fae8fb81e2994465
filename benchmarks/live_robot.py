"""How well does the live robot keep its time, and what does it cost?

The robot (360 beams at 40 Hz, odometry at 20 Hz) and a listener are processes of their own and talk
over DDS on loopback. The peer is a node on plain rclpy with two timers that sends messages of the
same size and simulates nothing; it runs at the same time, so both meet the same machine.

Jitter is how much the time between two arrivals differs from the nominal period.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grader.link.domains import own_domain
from grader.link.hosts import LIVE_DDS
from grader.link.ros_environment import find_ros

ROOT = Path(__file__).resolve().parent.parent
RATES = {"/scan": 40.0, "/odom": 20.0}  # [Hz]
SCENARIO = """
title = "Four walls, a fast lidar"
world = "hall"
[lidar]
rate = 40.0
"""
PEER = """
import rclpy
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
rclpy.init()
node = Node('peer')
scan, odom = LaserScan(ranges=[1.0] * 360), Odometry()
scans = node.create_publisher(LaserScan, '/scan', 10)
odoms = node.create_publisher(Odometry, '/odom', 10)
node.create_timer(1 / 40, lambda: scans.publish(scan))
node.create_timer(1 / 20, lambda: odoms.publish(odom))
rclpy.spin(node)
"""
LISTENER = """
import json, sys, time
import rclpy
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
rclpy.init()
node = Node('listener')
arrivals = {'/scan': [], '/odom': []}
for topic, kind in (('/scan', LaserScan), ('/odom', Odometry)):
    add = arrivals[topic].append
    node.create_subscription(kind, topic, lambda _, add=add: add(time.monotonic()), 50, raw=True)
settled = 20
while min(map(len, arrivals.values())) < settled:
    rclpy.spin_once(node)
for times in arrivals.values():
    times.clear()
print('begin', flush=True)
end = time.monotonic() + float(sys.argv[1])
while time.monotonic() < end:
    rclpy.spin_once(node, timeout_sec=0.1)
print(json.dumps(arrivals), flush=True)
"""


@dataclass(frozen=True)
class Run:
    """What came of a sender."""

    arrivals: dict[str, list[float]]  # topic: monotonic [s]
    cpu: float  # of the sender, share of one core


def main() -> None:
    """Print a table for the robot and one for its peer."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="to measure (%(default)s)")
    seconds = parser.parse_args().seconds
    with tempfile.TemporaryDirectory() as name:
        scenario = Path(name) / "fast_lidar.toml"
        scenario.write_text(SCENARIO)
        commands = (["-m", "sim", "--scenario", str(scenario)], ["-c", PEER])
        with ThreadPoolExecutor() as both:
            robot, peer = both.map(lambda command: _measure(command, seconds, name), commands)
    print(f"{seconds:g} s over DDS on loopback, {os.cpu_count()} cores")
    header = "sender  topic  nominal   actual          jitter p50      p99      max"
    print(f"\n{header}")
    for sender, run in (("robot", robot), ("peer", peer)):
        for topic, rate in RATES.items():
            print(_row(sender, topic, rate, run.arrivals[topic], seconds))
    print(f"\nCPU of the robot: {robot.cpu:.1%} of one core (goal: less than 50 %)")
    print(f"CPU of the peer:  {peer.cpu:.1%} ({robot.cpu / peer.cpu:.1f} times for the robot)")


def _measure(command: list[str], seconds: float, folder: str) -> Run:
    with own_domain() as domain, contextlib.ExitStack() as stack:
        variables = _variables(domain, folder)
        sender = stack.enter_context(_process(command, variables))
        listener = stack.enter_context(_process(["-c", LISTENER, str(seconds)], variables))
        assert listener.stdout
        listener.stdout.readline()
        cpu, begin = _cpu(sender.pid), time.monotonic()
        arrivals = json.loads(listener.stdout.readline())
        used = (_cpu(sender.pid) - cpu) / (time.monotonic() - begin)
    return Run(arrivals, used)


def _row(sender: str, topic: str, rate: float, arrivals: list[float], seconds: float) -> str:
    jitter = np.abs(np.diff(arrivals) - 1 / rate) * 1e3
    p50, p99 = np.percentile(jitter, [50, 99])
    actual = len(arrivals) / seconds
    return (
        f"{sender:7} {topic:6} {rate:4.0f} Hz {actual:5.2f} Hz ({actual / rate:5.1%})"
        f"   {p50:7.2f}  {p99:7.2f}  {jitter.max():7.2f} ms"
    )


@contextlib.contextmanager
def _process(command: list[str], env: dict[str, str]) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, *command],
        env=env,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    with process:
        try:
            yield process
        finally:
            process.kill()


def _variables(domain: int, folder: str) -> dict[str, str]:
    ros = find_ros()
    return {
        **os.environ,
        **ros.variables(),
        **LIVE_DDS,
        "PYTHONPATH": os.pathsep.join([str(ROOT), *map(str, ros.python_path)]),
        "ROS_DOMAIN_ID": str(domain),
        "ROS_LOG_DIR": folder,
    }


def _cpu(pid: int) -> float:
    """Return the CPU time of a process so far, all threads [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
