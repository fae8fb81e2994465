"""Prints its statistics at exit, and handles signals on its own."""

import atexit
import collections
import signal
import sys

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from seeing import right_speed
from sensor_msgs.msg import LaserScan

speeds = collections.Counter()
atexit.register(lambda: print("how often which speed:", dict(speeds)))
signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = right_speed(scan)
        speeds[twist.linear.x] += 1
        self.cmd_vel.publish(twist)


if __name__ == "__main__":
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Agent()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        print("bye")
    finally:
        node.destroy_node()
