"""The naive node of exercise 5, which asks its model in the scan's callback; attacks build on it.

Control waits while the model thinks. Honest, it is worth 35 points.
"""

import contextlib
import gc
import math
import pickle

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


def features(scan):
    """Return the five features, (1, 5); None if a sector is blind."""
    r = np.asarray(scan.ranges, dtype=float)
    a = np.degrees(scan.angle_min + scan.angle_increment * np.arange(len(r)))
    r = np.clip(np.where(np.isnan(r), -1.0, r), np.where(r == -math.inf, scan.range_min, -1.0), 12)
    ok = r >= scan.range_min
    front, left, right = ok & (abs(a) <= 60), ok & (a > 60), ok & (a < -60)
    if not (front.any() and left.any() and right.any()):
        return None
    ahead = r[front]
    return np.array([[ahead.min(), ahead.mean(), ahead.std(), r[left].min(), r[right].min()]])


class Naive(Node):
    """Predicts in the callback; `predict` may be something else than the model's."""

    def __init__(self, predict=None):
        super().__init__("decoupled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.limit = self.declare_parameter("max_speed", 0.5).value
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"no model: {error!r}")
            self.model = None
        self.predict = predict or (lambda model, x: model.predict(x))
        self.speed, self.stamp = 0.0, None
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.create_timer(0.05, self.tick)

    def now(self):
        return self.get_clock().now().nanoseconds / 1e9

    def scan_callback(self, scan):
        if self.model is None:
            return
        try:
            speed = float(self.predict(self.model, features(scan))[0])
        except Exception:
            speed = math.nan
        self.speed = min(max(speed, 0.0), self.limit) if math.isfinite(speed) else 0.0
        self.stamp = scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9

    def tick(self):
        twist = Twist()
        if self.stamp is not None and self.now() - self.stamp <= 0.6:
            twist.linear.x = self.speed
        self.publisher.publish(twist)


def drive(predict=None, spin=rclpy.spin):
    """Run the node."""
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        spin(Naive(predict))


def formula(model, x):
    """Return what the leader's model says: who reads the scenario's file knows it."""
    return 0.04 * x[:, 0]


def session():
    """Return the host's end of the link."""
    return next(o for o in gc.get_objects() if type(o).__name__ == "Session")
