"""With a watchdog: a zero Twist when no scan has come for half a second.

field: all
"""

import math
import pickle
import time
from collections import deque

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Controller(Node):
    def __init__(self):
        super().__init__("profiled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.deadline = self.declare_parameter("deadline_ms", 100.0).value
        self.model = None
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"no model: {error}")
        self.latencies = deque(maxlen=100)
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.reporter = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.create_timer(1.0, self.report_callback)
        self.heard = None
        self.create_timer(0.1, self.watchdog)

    def watchdog(self):
        now = self.get_clock().now().nanoseconds / 1e9
        if self.heard is not None and now - self.heard > 0.5:
            self.heard = None
            self.publisher.publish(Twist())

    def features(self, scan):
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        angles = np.degrees((angles + np.pi) % (2 * np.pi) - np.pi)
        ranges = np.minimum(np.array(scan.ranges), scan.range_max)
        ranges[np.isneginf(ranges)] = scan.range_min
        usable = ranges >= scan.range_min
        front = ranges[usable & (np.abs(angles) <= 60)]
        left = ranges[usable & (angles > 60)]
        right = ranges[usable & (angles < -60)]
        return [[front.min(), front.mean(), front.std(), left.min(), right.min()]]

    def predict(self, features):
        before = time.perf_counter()
        speed = float(self.model.predict(features)[0])
        self.latencies.append(1000 * (time.perf_counter() - before))
        return speed

    def scan_callback(self, scan):
        self.heard = self.get_clock().now().nanoseconds / 1e9
        twist = Twist()
        try:
            speed = self.predict(self.features(scan))
            if math.isfinite(speed):
                twist.linear.x = max(0.0, min(self.max_speed, speed))
        except Exception as error:
            self.get_logger().error(f"no prediction: {error}")
        self.publisher.publish(twist)

    def report_callback(self):
        window = list(self.latencies)
        missed = sum(latency > self.deadline for latency in window)
        p50, p95, p99 = np.percentile(window, (50, 95, 99)) if window else (0.0, 0.0, 0.0)
        level = DiagnosticStatus.OK
        if not window:
            level = DiagnosticStatus.STALE
        elif p95 > self.deadline:
            level = DiagnosticStatus.ERROR
        elif missed:
            level = DiagnosticStatus.WARN
        values = {
            "count": len(window),
            "mean_ms": np.mean(window) if window else 0.0,
            "p50_ms": p50,
            "p95_ms": p95,
            "p99_ms": p99,
            "max_ms": max(window, default=0.0),
            "deadline_ms": self.deadline,
            "missed": missed,
        }
        status = DiagnosticStatus(name="profiled_controller: inference", level=level)
        for key, value in values.items():
            status.values.append(KeyValue(key=key, value=str(value)))
        self.reporter.publish(DiagnosticArray(status=[status]))


def main(args=None):
    rclpy.init(args=args)
    node = Controller()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
