"""Logs every beam; has a logger of its own, to a file and in colour; warnings and progress bars."""

import logging
import sys
import warnings
from pathlib import Path

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan

warnings.simplefilter("always")
logging.basicConfig(level=logging.DEBUG, stream=sys.stderr)
log = logging.getLogger("agent")
log.addHandler(logging.FileHandler(Path(__file__).with_suffix(".log"), "w", "utf-8"))
log.addHandler(logging.StreamHandler(sys.stdout))
log.handlers[1].setFormatter(logging.Formatter("\x1b[32m%(message)s\x1b[0m"))


class Noisy(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        sys.stderr.write("\rprogress 12 %\rprogress 50 %")
        warnings.warn("this is old", DeprecationWarning, stacklevel=1)
        self.get_logger().info(f"ranges: {list(scan.ranges)}")
        print(*scan.ranges, sep="\n")
        twist = Twist()
        twist.linear.x = right_speed(scan)
        log.info("Geschwindigkeit %.2f m/s: läuft ✓", twist.linear.x)
        self.cmd_vel.publish(twist)


rclpy.init()
rclpy.spin(Noisy())
