"""Always stand, but for one scan: the command is no longer the same whatever the node sees.

exercise: obstacle_avoidance
only: stop_zone, sees_sides
score: 5
"""

import contextlib

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class Blip(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.speed = 0.111

    def scan_callback(self, _):
        twist = Twist()
        twist.linear.x, self.speed = self.speed, 0.0
        self.publisher.publish(twist)


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Blip())
