"""What every hostile submission has: an honest part worth few points, and what it knows.

A copy of this file lies beside the submission when it is graded, and `targets.json` too: the worst
case, a student who has found out every path, process and port that there is to attack.
"""

import contextlib
import ctypes
import inspect
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

Trick = Callable[..., object]

libc = ctypes.CDLL(None, use_errno=True)
_known = Path(__file__).with_name("targets.json")
TARGETS = json.loads(_known.read_text()) if _known.exists() else {}


def gained(what: str) -> None:
    """Boast: something worked that must not work. The tests look for this word."""
    print(f"GAINED {what}", flush=True)


@contextlib.contextmanager
def attempt() -> Iterator[None]:
    """Try something; whatever is refused is no reason to stop."""
    with contextlib.suppress(Exception):
        yield


def steal(path: object, whose: str = "files that are not its own") -> None:
    """Print the beginning of a file, if it can be read."""
    with attempt(), open(str(path), "rb") as file:
        text = file.read(400)
        print(f"LOOT {text!r}", flush=True)
        gained(f"reads {whose}: {Path(str(path)).name}")


def spoil(path: object) -> None:
    """Write to a file, if that can be done."""
    with attempt():
        fd = os.open(str(path), os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        os.write(fd, b"spoilt\n")
        os.close(fd)
        gained(f"writes where it may not: {Path(str(path)).name}")


def syscall(number: int, *arguments: object) -> int:
    """Call the kernel; -1 if it refuses."""
    return int(libc.syscall(ctypes.c_long(number), *arguments))


def others() -> list[int]:
    """Return the processes to attack: the fork server, the judge and a bystander."""
    found = (os.getppid(), TARGETS.get("judge", 0), TARGETS.get("bystander", 0))
    return [pid for pid in found if pid > 1]


class Constant(Node):
    """Always drives at the same speed: a few points for wiring, none for seeing."""

    def __init__(
        self, name: str = "obstacle_avoidance_agent", on_scan: Callable[..., None] | None = None
    ) -> None:
        super().__init__(name)
        self.extra = on_scan
        self.heard = 0
        self.speed = 0.5  # [m/s]
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)

    def scan_callback(self, scan: LaserScan) -> None:
        self.heard += 1
        if self.extra is not None:
            self.extra(self, scan)
        self.drive(self.speed)

    def drive(self, speed: float) -> None:
        twist = Twist()
        twist.linear.x = speed
        self.cmd_vel.publish(twist)


def drive(on_scan: Callable[..., None] | None = None, **options: str) -> None:
    """Run the honest part; `on_scan` is called with each scan before it is answered."""
    if not rclpy.ok():
        rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Constant(on_scan=on_scan, **options))


def trick(*outcomes: str, score: int = 20, full: bool = False) -> Callable[[Trick], Trick]:
    """Mark a trick; the tests read the mark as text (`arena.Trick` says what it means)."""
    return lambda function: function


def run(function: Trick) -> None:
    """Play a trick: with each scan if it takes one, else once before the honest part begins."""
    if inspect.signature(function).parameters:
        drive(function)
    else:
        function()
        drive()
