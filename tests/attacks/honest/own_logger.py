"""Has a logger of its own, which writes to a file in its folder and to stdout in colour."""

import logging
import sys
from pathlib import Path

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan

log = logging.getLogger("agent")
log.setLevel(logging.INFO)
log.addHandler(logging.FileHandler(Path(__file__).with_suffix(".log"), "w", "utf-8"))
log.addHandler(logging.StreamHandler(sys.stdout))
log.handlers[1].setFormatter(logging.Formatter("\x1b[32m%(message)s\x1b[0m"))


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = right_speed(scan)
        log.info("Geschwindigkeit %.2f m/s: läuft ✓", twist.linear.x)
        self.cmd_vel.publish(twist)


rclpy.init()
rclpy.spin(Agent())
