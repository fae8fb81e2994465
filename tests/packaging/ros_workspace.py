"""A workspace with our two packages, programs that run in it, and a robot that asks them."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from grader.course.exercises import ROOT, SOLUTIONS
from rclpy_virtual_time.link.domains import own_domain

SCANS = """
import sys, rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

rclpy.init()
node, heard = Node("scans"), []
scans = node.create_publisher(LaserScan, "/scan", 10)
node.create_subscription(Twist, "/cmd_vel", heard.append, 10)
scan = LaserScan(angle_min=-3.1, angle_increment=0.1, range_min=0.15, range_max=12.0)
scan.ranges = [float(sys.argv[1])] * 63
node.create_timer(0.05, lambda: scans.publish(scan))
while not heard:
    rclpy.spin_once(node)
print(heard[0].linear.x)
"""
COMMANDS = """
import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

rclpy.init()
node, moved, seen = Node("commands"), [], []
commands = node.create_publisher(Twist, "/cmd_vel", 10)
node.create_subscription(LaserScan, "/scan", seen.append, qos_profile_sensor_data)
node.create_subscription(
    Odometry, "/odom", lambda o: moved.append(o.twist.twist.linear.x), qos_profile_sensor_data)
twist = Twist()
twist.linear.x = 0.3
node.create_timer(0.1, lambda: commands.publish(twist))
while not (seen and moved and moved[-1] > 0.2):
    rclpy.spin_once(node)
print(len(seen[-1].ranges))
"""


def copy_sources(source: Path) -> None:
    """Copy both packages, as a checkout in a workspace has them; exercise 1 is done there."""
    away = shutil.ignore_patterns("__pycache__", "build", "*.egg-info")
    for folder in ("sim", "exercises"):
        shutil.copytree(ROOT / folder, source / folder, ignore=away)
    done = "obstacle_avoidance/obstacle_avoidance_agent.py"
    shutil.copyfile(SOLUTIONS / done, source / "exercises" / done)


def environment(prefixes: list[Path], more: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the variables of a terminal in which these install spaces are sourced."""
    python = f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
    return terminal() | {
        "AMENT_PREFIX_PATH": os.pathsep.join(str(prefix) for prefix in prefixes),
        "PYTHONPATH": os.pathsep.join(str(prefix / python) for prefix in prefixes),
        **(more or {}),
    }


def terminal() -> dict[str, str]:
    """Return the variables of a terminal: this Python first on the PATH, no ROS sourced."""
    kept = {name: os.environ[name] for name in ("HOME", "LANG", "TMPDIR") if name in os.environ}
    path = os.pathsep.join((str(Path(sys.executable).parent), "/usr/local/bin", "/usr/bin", "/bin"))
    return kept | {"PATH": path}


@contextmanager
def on_a_network_of_its_own() -> Iterator[dict[str, str]]:
    """Yield the variables of a DDS domain that nobody else on this machine is in."""
    with own_domain() as domain:
        yield {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def _hear_ctrl_c() -> None:
    """Take back that a shell's background jobs, and what they start, ignore SIGINT."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextmanager
def running(command: list[str], variables: Mapping[str, str], folder: Path) -> Iterator[None]:
    """Run a program in the background, and stop it in the end as Ctrl-C does.

    How it ends is not asked: rclpy may raise where it is just taking a message.
    """
    log = folder / f"{sum(1 for _ in folder.iterdir())}.log"
    with log.open("w") as output:
        program = subprocess.Popen(
            command,
            env=dict(variables),
            cwd=folder,
            stdout=output,
            stderr=output,
            preexec_fn=_hear_ctrl_c,  # noqa: PLW1509  (it only sets a handler)
        )
    try:
        yield
        assert program.poll() is None, f"it has ended:\n{log.read_text('utf-8')}"
        program.send_signal(signal.SIGINT)
        program.wait(60)
    finally:
        program.kill()
        program.wait()


def ask(script: str, variables: Mapping[str, str], *arguments: str) -> str:
    """Run a program that ends when it has its answer; return the answer."""
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        env=dict(variables), cwd="/", capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()
