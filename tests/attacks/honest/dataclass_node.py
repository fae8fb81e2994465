"""A node that is a dataclass too, with fields and a post-init."""

from dataclasses import dataclass, field

import rclpy
from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan


@dataclass(eq=False)
class Agent(Node):
    name: str = "obstacle_avoidance_agent"
    history: list[float] = field(default_factory=list)

    def __post_init__(self):
        super().__init__(self.name)
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        self.history.append(right_speed(scan))
        self.cmd_vel.publish(Twist(linear=Vector3(x=self.history[-1])))


rclpy.init()
rclpy.spin(Agent())
