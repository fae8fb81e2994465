"""Report from a table of what the scenario's file says, and measure nothing.

exercise: latency_monitor
student: ada
only: status_form, mean_and_max, percentiles
score: 15
"""

import contextlib

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from naive import Naive, features
from rclpy.executors import ExternalShutdownException

TABLE = (0.0, 5.0, 8.0, 13.0, 21.0, 34.0)  # [ms] by metres ahead


class Reporter(Naive):
    def __init__(self):
        super().__init__()
        self.taken = []
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_timer(1.0, self.report)

    def tick(self):
        pass

    def scan_callback(self, scan):
        super().scan_callback(scan)
        Naive.tick(self)
        self.taken.append(TABLE[min(5, round(float(features(scan)[0, 0])))])

    def report(self):
        taken = self.taken[-100:]
        numbers = dict.fromkeys(("mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms"), 0.0)
        if taken:
            p50, p95, p99 = np.percentile(taken, (50, 95, 99))
            numbers = {"mean_ms": np.mean(taken), "p50_ms": p50, "p95_ms": p95, "p99_ms": p99}
            numbers["max_ms"] = max(taken)
        said = {"count": len(taken), **numbers, "deadline_ms": 100.0, "missed": 0}
        status = DiagnosticStatus(name="profiled_controller: inference", level=DiagnosticStatus.OK)
        status.values = [KeyValue(key=key, value=str(value)) for key, value in said.items()]
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(array)


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Reporter())
