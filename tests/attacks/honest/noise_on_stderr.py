"""Writes much to stderr: warnings, progress bars with carriage returns, half lines."""

import logging
import sys
import warnings

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from seeing import right_speed
from sensor_msgs.msg import LaserScan

warnings.simplefilter("always")
logging.basicConfig(level=logging.DEBUG, stream=sys.stderr)


class Noisy(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(
            LaserScan, "/scan", self.on_scan, rclpy.qos.qos_profile_sensor_data
        )

    def on_scan(self, scan):
        sys.stderr.write("\rprogress 12 %\rprogress 50 %")
        warnings.warn("this is old", DeprecationWarning, stacklevel=1)
        logging.getLogger("mine").debug("a scan of %d beams", len(scan.ranges))
        twist = Twist()
        twist.linear.x = right_speed(scan)
        self.cmd_vel.publish(twist)


import rclpy.qos  # noqa: E402  (as students do)

rclpy.init()
rclpy.spin(Noisy())
