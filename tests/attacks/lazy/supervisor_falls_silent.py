"""Pass on one small command, and then stay silent: a stop that never comes is never wrong.

exercise: safety_supervisor
only: acceleration, e_stop, stale_command
score: 5
"""

import contextlib

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

LATER = 620_000_000  # [ns]


class Silent(Node):
    def __init__(self):
        super().__init__("safety_supervisor")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Twist, "/cmd_vel_raw", self.raw_callback, 10)
        self.create_subscription(LaserScan, "/scan", lambda _: None, 10)
        self.create_subscription(Bool, "/e_stop", lambda _: None, 10)
        self.begin = None
        self.done = False

    def raw_callback(self, raw):
        now = self.get_clock().now().nanoseconds
        self.begin = self.begin or now
        if self.done or now < self.begin + LATER:
            return
        self.done = True
        twist = Twist()
        twist.linear.x = min(raw.linear.x, 0.045)
        twist.angular.z = max(-1.9, min(1.9, raw.angular.z))
        self.publisher.publish(twist)


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Silent())
