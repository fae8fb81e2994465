"""Style: a NumPy ring buffer for the latencies, everything else vectorised.

field: all
"""

import pickle
from time import perf_counter

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan

PERCENTILES = {"p50_ms": 50, "p95_ms": 95, "p99_ms": 99}


class ProfiledController(Node):
    def __init__(self) -> None:
        super().__init__("profiled_controller")
        self.declare_parameters(
            "",
            [("model_path", "velocity_model.pkl"), ("max_speed", 0.5), ("deadline_ms", 100.0)],
        )
        self.ring = np.full(100, np.nan)
        self.calls = 0
        self.model = None
        try:
            with open(self.get_parameter("model_path").value, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(repr(error))
        self.commands = self.create_publisher(Twist, "/cmd_vel", 1)
        self.reports = self.create_publisher(DiagnosticArray, "/diagnostics", 1)
        qos = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos)
        self.create_timer(1.0, self.report_callback)

    def scan_callback(self, scan: LaserScan) -> None:
        speed = np.nan
        try:
            speed = self.timed_prediction(self.features(scan))
        except Exception as error:
            self.get_logger().error(repr(error))
        twist = Twist()
        limit = self.get_parameter("max_speed").value
        twist.linear.x = float(np.clip(speed, 0.0, limit)) if np.isfinite(speed) else 0.0
        self.commands.publish(twist)

    def timed_prediction(self, row: np.ndarray) -> float:
        began = perf_counter()
        prediction = self.model.predict(row)
        self.ring[self.calls % len(self.ring)] = 1e3 * (perf_counter() - began)
        self.calls += 1
        return float(np.ravel(prediction)[0])

    def features(self, scan: LaserScan) -> np.ndarray:
        r = np.asarray(scan.ranges, dtype=np.float64)
        r = np.where(r == -np.inf, scan.range_min, np.minimum(r, scan.range_max))
        theta = np.arange(r.size) * scan.angle_increment + scan.angle_min
        theta = np.degrees(np.arctan2(np.sin(theta), np.cos(theta)))
        keep = r >= scan.range_min
        r, theta = r[keep], theta[keep]
        front = r[np.abs(theta) <= 60]
        row = [front.min(), front.mean(), front.std(), r[theta > 60].min(), r[theta < -60].min()]
        return np.array([row])

    def report_callback(self) -> None:
        known = self.ring[~np.isnan(self.ring)]
        deadline = self.get_parameter("deadline_ms").value
        window = known if known.size else np.zeros(1)
        missed = int(np.count_nonzero(known > deadline))
        numbers = {key: np.percentile(window, q) for key, q in PERCENTILES.items()}
        numbers |= {"mean_ms": window.mean(), "max_ms": window.max(), "deadline_ms": deadline}
        numbers |= {"count": known.size, "missed": missed}
        level = DiagnosticStatus.OK
        if missed:
            level = DiagnosticStatus.WARN
        if numbers["p95_ms"] > deadline:
            level = DiagnosticStatus.ERROR
        if not known.size:
            level = DiagnosticStatus.STALE
        status = DiagnosticStatus(level=level, name="profiled_controller: inference")
        status.values = [KeyValue(key=key, value=f"{numbers[key]:g}") for key in numbers]
        report = DiagnosticArray(status=[status])
        report.header.stamp = self.get_clock().now().to_msg()
        self.reports.publish(report)


def main(args=None) -> None:
    rclpy.init(args=args)
    node = ProfiledController()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
