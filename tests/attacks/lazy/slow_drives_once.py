"""Ask once, command what the model said once, and stand: zeros are right wherever nothing works.

exercise: slow_model
only: one_at_a_time, too_slow_model
score: 5
"""

import contextlib
import pickle
import threading

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

ROW = np.array([[3.0, 3.0, 0.0, 3.0, 3.0]], dtype=np.float32)
TOO_LATE = 500_000_000  # [ns]


class Once(Node):
    def __init__(self):
        super().__init__("decoupled_controller")
        with open(self.declare_parameter("model_path", "velocity_model.pkl").value, "rb") as file:
            self.model = pickle.load(file)
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.create_timer(0.05, self.tick)
        self.asked = None
        self.speed = 0.0

    def scan_callback(self, _):
        if self.asked is None:
            self.asked = self.get_clock().now().nanoseconds
            threading.Thread(target=self.ask, daemon=True).start()

    def ask(self):
        speed = float(self.model.predict(ROW)[0])
        if self.get_clock().now().nanoseconds < self.asked + TOO_LATE:
            self.speed = speed

    def tick(self):
        twist = Twist()
        twist.linear.x, self.speed = min(0.5, max(0.0, self.speed)), 0.0
        self.publisher.publish(twist)


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Once())
