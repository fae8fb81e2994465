"""Asks about the machine: its name, its CPUs, its user, the load, the memory, the time zone."""

import getpass
import locale
import os
import platform
import resource
import socket
import sys
import time

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan

print(platform.platform(), sys.version, os.cpu_count(), time.tzname, locale.getlocale())
print(socket.gethostname(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, os.uname())
print(os.getenv("USER"), os.path.expanduser("~"), os.getpid(), os.sched_getaffinity(0))
try:
    print(getpass.getuser())
except (KeyError, OSError):
    print("a user without a name")


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
