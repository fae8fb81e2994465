"""Works with files: temporary ones, one beside itself, its own text, and its working folder."""

import json
import os
import shutil
import tempfile
from pathlib import Path

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan

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
        twist = Twist()
        twist.linear.x = min(
            json.loads(Path("link.json").read_text()),
            key=lambda speed: abs(speed - right_speed(scan)),
        )
        print(twist.linear.x, file=self.file, flush=True)
        self.cmd_vel.publish(twist)


rclpy.init()
rclpy.spin(Agent())
