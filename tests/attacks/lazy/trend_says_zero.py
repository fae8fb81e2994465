"""Drive at one speed, and say at each scan that nothing comes closer: no memory, no trend.

exercise: trend_memory
score: 20
"""

import contextlib

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64


class Trend(Node):
    def __init__(self):
        super().__init__("trend_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.closing_speed = self.create_publisher(Float64, "/closing_speed", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)

    def scan_callback(self, scan):
        twist = Twist()
        twist.linear.x = 0.3
        self.cmd_vel.publish(twist)
        self.closing_speed.publish(Float64(data=0.0))


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Trend())
