"""A pool of threads computes, a queue hands over, a condition wakes; numpy does the sums."""

import queue
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.pool = ThreadPoolExecutor(2)
        self.speeds = queue.Queue()
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        np.sort(np.nan_to_num(np.array(scan.ranges, dtype=float)))
        self.pool.submit(lambda: self.speeds.put(right_speed(scan))).result()
        twist = Twist()
        twist.linear.x = self.speeds.get(timeout=1.0)
        self.cmd_vel.publish(twist)


rclpy.init()
executor = MultiThreadedExecutor()
executor.add_node(Agent())
executor.spin()
