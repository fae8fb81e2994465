"""Ask the model, measure nothing, say that each call took 1 ms, and judge that rightly.

exercise: latency_monitor
student: ada
only: status_form, mean_and_max, percentiles, window, missed, levels
score: 20
"""

import contextlib

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from naive import Naive
from rclpy.executors import ExternalShutdownException


class Reporter(Naive):
    def __init__(self):
        super().__init__()
        self.asked = 0
        self.deadline = self.declare_parameter("deadline_ms", 100.0).value
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_timer(1.0, self.report)

    def tick(self):
        pass

    def scan_callback(self, scan):
        super().scan_callback(scan)
        Naive.tick(self)
        self.asked += 1

    def report(self):
        count = min(self.asked, 100)
        late = self.deadline < 1.0
        numbers = dict.fromkeys(("mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms"), 1.0)
        said = {"count": count, **numbers, "deadline_ms": self.deadline, "missed": count * late}
        level = DiagnosticStatus.ERROR if late else DiagnosticStatus.OK
        status = DiagnosticStatus(name="profiled_controller: inference", level=level)
        status.values = [KeyValue(key=key, value=str(value)) for key, value in said.items()]
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(array)


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Reporter())
