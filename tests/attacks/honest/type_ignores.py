"""# type: ignore on each line, annotations that don't exist, a future import."""
# mypy: ignore-errors
# ruff: noqa

from __future__ import annotations

import rclpy  # type: ignore
from geometry_msgs.msg import Twist  # type: ignore
from rclpy.node import Node  # type: ignore[import]
from rclpy.qos import qos_profile_sensor_data  # type: ignore
from sensor_msgs.msg import LaserScan  # type: ignore  # pyright: ignore
from seeing import right_speed  # type: ignore


class Agent(Node):  # type: ignore[misc]
    cmd_vel: NoSuchType  # type: ignore

    def __init__(self: Agent) -> NoSuchType:  # type: ignore
        super().__init__("obstacle_avoidance_agent")  # type: ignore
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)  # type: ignore
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)  # type: ignore

    def on_scan(self, scan: LaserScan | Missing) -> Optional[None]:  # type: ignore
        twist: Twist = Twist()  # type: ignore
        twist.linear.x = right_speed(scan)  # type: ignore
        self.cmd_vel.publish(twist)  # type: ignore


rclpy.init()  # type: ignore
rclpy.spin(Agent())  # type: ignore
