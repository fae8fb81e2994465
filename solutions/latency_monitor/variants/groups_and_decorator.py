"""Style: a decorator measures the model's predict; callback groups keep the report on its beat.

field: all
"""

import functools
import math
import pickle
import time
from collections import deque
from threading import Lock

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Window:
    """The latencies of the last calls [ms]; safe to use from several threads."""

    def __init__(self, size: int = 100) -> None:
        self._lock = Lock()
        self._latencies: deque[float] = deque([], size)

    def measured(self, function):
        @functools.wraps(function)
        def wrapper(*args):
            start = time.perf_counter()
            result = function(*args)
            took = time.perf_counter() - start
            with self._lock:
                self._latencies.append(took * 1e3)
            return result

        return wrapper

    def copy(self) -> np.ndarray:
        with self._lock:
            return np.array(self._latencies)


class ProfiledController(Node):
    def __init__(self) -> None:
        super().__init__("profiled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.deadline = self.declare_parameter("deadline_ms", 100.0).value
        self.window = Window()
        self.predict = None
        try:
            with open(path, "rb") as file:
                self.predict = self.window.measured(pickle.load(file).predict)
        except Exception as error:
            self.get_logger().error(f"no model in {path}: {error}")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(
            LaserScan,
            "/scan",
            self.scan_callback,
            qos_profile_sensor_data,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )
        self.create_timer(1.0, self.report, callback_group=MutuallyExclusiveCallbackGroup())

    def scan_callback(self, scan: LaserScan) -> None:
        twist = Twist()
        twist.linear.x = self.decide(scan)
        self.cmd_vel.publish(twist)

    def decide(self, scan: LaserScan) -> float:
        if self.predict is None:
            return 0.0
        try:
            speed = float(self.predict(self.features(scan))[0])
        except Exception as error:
            self.get_logger().error(str(error))
            return 0.0
        return sorted((0.0, speed, self.max_speed))[1] if math.isfinite(speed) else 0.0

    @staticmethod
    def features(scan: LaserScan) -> np.ndarray:
        ranges = np.array(scan.ranges, dtype=np.float32)
        angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        angles = np.where(angles > np.pi, angles - 2 * np.pi, angles)
        ranges[np.isneginf(ranges)] = scan.range_min
        ranges = np.minimum(ranges, np.float32(scan.range_max))
        good = ranges >= np.float32(scan.range_min)
        front = ranges[good & (np.abs(angles) <= np.pi / 3)]
        left = ranges[good & (angles > np.pi / 3)]
        right = ranges[good & (angles < -np.pi / 3)]
        return np.array([[front.min(), front.mean(), front.std(), left.min(), right.min()]])

    def report(self) -> None:
        window = self.window.copy()
        missed = int((window > self.deadline).sum())
        p50, p95, p99 = np.percentile(window, [50, 95, 99]) if window.size else (0.0, 0.0, 0.0)
        if not window.size:
            level = DiagnosticStatus.STALE
        elif not missed:
            level = DiagnosticStatus.OK
        else:
            level = DiagnosticStatus.ERROR if p95 > self.deadline else DiagnosticStatus.WARN
        values = {
            "count": window.size,
            "mean_ms": float(window.mean()) if window.size else 0.0,
            "p50_ms": float(p50),
            "p95_ms": float(p95),
            "p99_ms": float(p99),
            "max_ms": float(window.max(initial=0.0)),
            "deadline_ms": self.deadline,
            "missed": missed,
        }
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        message.status = [
            DiagnosticStatus(
                level=level,
                name="profiled_controller: inference",
                values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
            )
        ]
        self.diagnostics.publish(message)


def main(args=None) -> None:
    rclpy.init(args=args)
    node = ProfiledController()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
