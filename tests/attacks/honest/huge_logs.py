"""Logs every beam of every scan."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        self.get_logger().info(f"ranges: {list(scan.ranges)}")
        print(*scan.ranges, sep="\n")
        twist = Twist()
        twist.linear.x = right_speed(scan)
        self.cmd_vel.publish(twist)


rclpy.init()
rclpy.spin(Agent())
