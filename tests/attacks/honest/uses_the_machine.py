"""Asks for CPUs, user, load and time zone; works with files, temporary ones and its own text."""

import getpass
import json
import locale
import os
import platform
import resource
import shutil
import socket
import sys
import tempfile
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan

print(platform.platform(), sys.version, os.cpu_count(), time.tzname, locale.getlocale())
print(socket.gethostname(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, os.uname())
print(os.getenv("USER"), os.path.expanduser("~"), os.getpid(), os.sched_getaffinity(0))
try:
    print(getpass.getuser())
except (KeyError, OSError):
    print("a user without a name")
here = Path(os.getcwd())
assert Path(__file__).resolve().parent == here.resolve()
assert "obstacle" in Path(__file__).read_text(encoding="utf-8")
with tempfile.TemporaryDirectory() as folder:
    target = Path(folder) / "copy.py"
    shutil.copy(__file__, target)
    shutil.copytree(folder, Path(folder).with_name("again"))
    os.chmod(target, 0o600)
    os.utime(target)
with tempfile.NamedTemporaryFile("w+", suffix=".json") as file:
    json.dump({"speeds": [0.0, 0.15, 0.5]}, file)
    file.seek(0)
    SPEEDS = json.load(file)["speeds"]
(here / "settings.json").write_text(json.dumps(SPEEDS))
os.rename("settings.json", "old.json")
os.makedirs("a/b/c")
Path("link.json").symlink_to("old.json")


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)
        self.file = open("scans.csv", "w")  # noqa: SIM115

    def on_scan(self, scan):
        speeds = json.loads(Path("link.json").read_text())
        twist = Twist()
        twist.linear.x = min(speeds, key=lambda speed: abs(speed - right_speed(scan)))
        print(twist.linear.x, file=self.file, flush=True)
        self.cmd_vel.publish(twist)


rclpy.init()
rclpy.spin(Agent())
