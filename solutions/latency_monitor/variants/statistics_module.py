"""Style: the standard library's statistics, a context manager for the stopwatch, a watchdog.

field: all
"""

import math
import pickle
import statistics
import time
from collections import deque
from contextlib import contextmanager

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Stopwatch:
    """Measures blocks of code that end without an exception [ms]."""

    def __init__(self, keep: int) -> None:
        self.laps: deque[float] = deque(maxlen=keep)

    @contextmanager
    def lap(self):
        begin = time.perf_counter_ns()
        yield
        self.laps.append((time.perf_counter_ns() - begin) / 1e6)

    def percentile(self, percent: int) -> float:
        if len(self.laps) < 2:
            return sum(self.laps)
        return statistics.quantiles(self.laps, n=100, method="inclusive")[percent - 1]


def features(scan: LaserScan) -> list[float]:
    """Raise ValueError when a sector is blind."""
    sectors: dict[str, list[float]] = {"front": [], "left": [], "right": []}
    for number, reading in enumerate(scan.ranges):
        if math.isnan(reading):
            continue
        if reading == -math.inf:
            reading = scan.range_min
        if reading < scan.range_min:
            continue
        degrees = math.degrees(scan.angle_min + number * scan.angle_increment)
        degrees = (degrees + 180) % 360 - 180
        name = "front" if -60 <= degrees <= 60 else "left" if degrees > 60 else "right"
        sectors[name].append(min(reading, scan.range_max))
    front = sectors["front"]
    if not front:
        raise ValueError("blind ahead")
    mean, std = statistics.fmean(front), statistics.pstdev(front)
    return [min(front), mean, std, min(sectors["left"]), min(sectors["right"])]


class ProfiledController(Node):
    def __init__(self) -> None:
        super().__init__("profiled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.deadline = self.declare_parameter("deadline_ms", 100.0).value
        self.watch = Stopwatch(keep=100)
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"{path}: {error}")
            self.model = None
        self.cmd_vel = self.create_publisher(Twist, "cmd_vel", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "diagnostics", 10)
        self.create_subscription(LaserScan, "scan", self.on_scan, qos_profile_sensor_data)
        self.create_timer(1.0, self.report)
        self.heard: float | None = (
            None  # [s] when the last scan came; None: the watchdog has barked
        )
        self.create_timer(0.1, self.stop_without_scans)
        self.report()  # nobody has to wait a second to see that it runs

    def seconds(self) -> float:
        return self.get_clock().now().nanoseconds / 1e9

    def stop_without_scans(self) -> None:
        if self.heard is not None and self.seconds() - self.heard > 0.5:
            self.heard = None
            self.cmd_vel.publish(Twist())

    def on_scan(self, scan: LaserScan) -> None:
        self.heard = self.seconds()
        twist = Twist()
        try:
            row = features(scan)
            with self.watch.lap():
                answer = self.model.predict([row])
            speed = float(answer[0])
            if math.isfinite(speed):
                twist.linear.x = min(max(speed, 0.0), self.max_speed)
        except Exception as error:
            self.get_logger().warning(f"standing still: {error}")
        self.cmd_vel.publish(twist)

    def report(self) -> None:
        laps, watch = self.watch.laps, self.watch
        missed = len([lap for lap in laps if lap > self.deadline])
        p95 = watch.percentile(95)
        status = DiagnosticStatus(name="profiled_controller: inference", hardware_id="cpu")
        if not laps:
            status.level, status.message = DiagnosticStatus.STALE, "no prediction yet"
        elif p95 > self.deadline:
            status.level, status.message = DiagnosticStatus.ERROR, "too slow"
        elif missed:
            status.level, status.message = DiagnosticStatus.WARN, "sometimes too slow"
        else:
            status.level, status.message = DiagnosticStatus.OK, "in time"
        for key, text in (
            ("count", f"{len(laps)}"),
            ("mean_ms", f"{statistics.fmean(laps) if laps else 0.0:.1f}"),
            ("p50_ms", f"{watch.percentile(50):.1f}"),
            ("p95_ms", f"{p95:.1f}"),
            ("p99_ms", f"{watch.percentile(99):.1f}"),
            ("max_ms", f"{max(laps, default=0.0):.1f}"),
            ("deadline_ms", f"{self.deadline:.1f}"),
            ("missed", f"{missed}"),
        ):
            status.values.append(KeyValue(key=key, value=text))
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(message)


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
