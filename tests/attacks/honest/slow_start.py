"""Takes its time to start: sleeps while it is imported, as for a driver, and computes a table."""

import time

time.sleep(0.3)

import rclpy  # noqa: E402
from geometry_msgs.msg import Twist  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.qos import qos_profile_sensor_data  # noqa: E402
from seeing import right_speed  # noqa: E402
from sensor_msgs.msg import LaserScan  # noqa: E402

TABLE = [i * i % 7 for i in range(3_000_000)]


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = right_speed(scan)
        self.cmd_vel.publish(twist)


rclpy.init()
rclpy.spin(Agent())
