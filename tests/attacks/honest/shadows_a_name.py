"""Calls its own things list, time, json and node: bad style, but no mistake."""

import time as json

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node as list
from rclpy.qos import qos_profile_sensor_data as min
from seeing import right_speed as print
from sensor_msgs.msg import LaserScan as str


class time(list):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(str, "/scan", self.on_scan, min)
        self.since = json.monotonic()

    def on_scan(self, id):
        twist = Twist()
        twist.linear.x = print(id)
        self.cmd_vel.publish(twist)


rclpy.init()
node = rclpy.spin(time())
