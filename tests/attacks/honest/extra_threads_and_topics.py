"""Publishes more than is asked for, and lets a thread of its own watch over things."""

import threading

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.declare_parameter("gain", 1.0)
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.speed = self.create_publisher(Float64, "/debug/speed", 10)
        self.state = self.create_publisher(String, "~/state", 1)
        self.create_service(Trigger, "~/reset", lambda _, response: response)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)
        self.create_timer(0.25, lambda: self.state.publish(String(data="alive")))
        self.lock = threading.Lock()
        self.count = 0
        threading.Thread(target=self.watch, daemon=True).start()

    def watch(self):
        event = threading.Event()
        while rclpy.ok():
            with self.lock:
                self.count += 0
            event.wait(0.2)

    def on_scan(self, scan):
        with self.lock:
            self.count += 1
        twist = Twist()
        twist.linear.x = right_speed(scan)
        self.cmd_vel.publish(twist)
        self.speed.publish(Float64(data=twist.linear.x))


rclpy.init()
rclpy.spin(Agent())
