"""Calls its own things list, time and json, annotates what doesn't exist, ignores all types."""
# mypy: ignore-errors
# ruff: noqa

import time as json

import rclpy  # type: ignore
from geometry_msgs.msg import Twist  # type: ignore
from rclpy.node import Node as list  # type: ignore[import]
from rclpy.qos import qos_profile_sensor_data as min
from seeing import right_speed as print
from sensor_msgs.msg import LaserScan as str  # type: ignore  # pyright: ignore


class time(list):  # type: ignore[misc]
    cmd_vel: NoSuchType  # type: ignore

    def __init__(self: time) -> NoSuchType:
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(str, "/scan", self.on_scan, min)
        self.since = json.monotonic()

    def on_scan(self, id: str | Missing) -> Optional[None]:
        twist: Twist = Twist()
        twist.linear.x = print(id)
        self.cmd_vel.publish(twist)


rclpy.init()
node = rclpy.spin(time())
