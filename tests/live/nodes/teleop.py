"""Publishes one velocity at 20 Hz, as a teleoperation node does, and says once who hears it.

teleop.py LINEAR ANGULAR [stamped]
"""

import sys

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node


class Teleop(Node):
    def __init__(self, linear: float, angular: float, stamped: bool) -> None:
        super().__init__("teleop")
        self.message = TwistStamped() if stamped else Twist()
        twist = self.message.twist if stamped else self.message
        twist.linear.x, twist.angular.z = linear, angular
        self.publisher = self.create_publisher(type(self.message), "/cmd_vel", 10)
        self.create_timer(0.05, self.on_timer)
        self.heard = False

    def on_timer(self) -> None:
        if not self.heard and self.publisher.get_subscription_count():
            self.heard = True
            print("a robot hears this", flush=True)
        self.publisher.publish(self.message)


rclpy.init()
rclpy.spin(Teleop(float(sys.argv[1]), float(sys.argv[2]), "stamped" in sys.argv))
