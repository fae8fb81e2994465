"""A model in the loop that is measured: the latency of each prediction, reported once a second.

Subscribes  /scan         sensor_msgs/msg/LaserScan            distances all around the robot [m]
Publishes   /cmd_vel      geometry_msgs/msg/Twist              forward speed [m/s], one per scan
            /diagnostics  diagnostic_msgs/msg/DiagnosticArray  latency of the last 100 calls, 1 Hz
Parameters  model_path   string  a pickled model with predict(X: (n, 5)) -> (n,) [m/s]
            max_speed    double  no command is faster [m/s]
            deadline_ms  double  a call that takes longer has missed its deadline [ms]
"""

import math
import pickle
import signal
import time
from collections import deque
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan

WINDOW = 100  # calls
REPORT_PERIOD = 1.0  # [s]
STATUS_NAME = "profiled_controller: inference"
FRONT_HALF_ANGLE = math.radians(60.0)  # [rad] the front sector is |θ| ≤ 60°


def extract_features(scan: LaserScan) -> np.ndarray | None:
    """Return what the model sees of a scan: one row of five features, (1, 5) float32 [m].

    Minimum, mean and population standard deviation of the front sector (|θ| ≤ 60°), minimum of
    the left sector (60° < θ ≤ 180°), minimum of the right sector (-180° ≤ θ < -60°). ``+inf`` and
    readings above ``range_max`` count as ``range_max``, ``-inf`` counts as ``range_min``; NaN and
    readings below ``range_min`` are dropped. ``None``: a sector has no usable reading.
    """
    ### BEGIN SOLUTION
    ranges = np.array(scan.ranges, dtype=float)
    ranges = np.where(ranges == -np.inf, scan.range_min, np.minimum(ranges, scan.range_max))
    usable = ranges >= scan.range_min  # False for NaN
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    angles = (angles + np.pi) % (2 * np.pi) - np.pi  # for lidars that count from 0 to 2π
    front = ranges[usable & (np.abs(angles) <= FRONT_HALF_ANGLE)]
    left = ranges[usable & (angles > FRONT_HALF_ANGLE)]
    right = ranges[usable & (angles < -FRONT_HALF_ANGLE)]
    if not (front.size and left.size and right.size):
        return None
    row = [front.min(), front.mean(), front.std(), left.min(), right.min()]
    return np.array([row], dtype=np.float32)
    ### SKELETON
    # # TODO(task 1): paste extract_features from your exercise 2; it fits as it is.
    # # Until then the model is asked about zeros, and only the checks of features fail.
    # return np.zeros((1, 5), dtype=np.float32)
    ### END SOLUTION


def latency_statistics(latencies: list[float], deadline: float) -> dict[str, float]:
    """Return mean, percentiles, maximum [ms] and the number of missed deadlines of latencies [ms].

    Percentiles lie between two measurements (linear interpolation). Without any measurement
    everything is 0.0.
    """
    ### BEGIN SOLUTION
    if not latencies:
        return dict.fromkeys(("mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms", "missed"), 0.0)
    p50, p95, p99 = np.percentile(latencies, (50, 95, 99))
    return {
        "mean_ms": float(np.mean(latencies)),
        "p50_ms": float(p50),
        "p95_ms": float(p95),
        "p99_ms": float(p99),
        "max_ms": max(latencies),
        "missed": sum(latency > deadline for latency in latencies),
    }
    ### SKELETON
    # # TODO(task 3): numpy.mean, numpy.percentile, max, and a count.
    # names = ("mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms", "missed")
    # return dict.fromkeys(names, 0.0)
    ### END SOLUTION


def level_of(count: int, missed: float, p95: float, deadline: float) -> bytes:
    """Return the level: STALE without a prediction, OK, WARN (some missed), ERROR (p95 too)."""
    ### BEGIN SOLUTION
    if count == 0:
        return DiagnosticStatus.STALE
    if p95 > deadline:
        return DiagnosticStatus.ERROR
    return DiagnosticStatus.WARN if missed else DiagnosticStatus.OK
    ### SKELETON
    # # TODO(task 4): compare, and return one of the constants of DiagnosticStatus.
    # return DiagnosticStatus.STALE
    ### END SOLUTION


class ProfiledController(Node):
    """Drives as the model says, and knows how long the model takes to say it."""

    def __init__(self) -> None:
        super().__init__("profiled_controller")
        model_path: str = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed: float = self.declare_parameter("max_speed", 0.5).value  # [m/s]
        self.deadline: float = self.declare_parameter("deadline_ms", 100.0).value  # [ms]
        self.model = self.load_model(model_path)
        self.latencies: deque[float] = deque(maxlen=WINDOW)  # [ms] of the last calls
        ### BEGIN SOLUTION
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diagnostics_publisher = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.scan_subscription = self.create_subscription(
            LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data
        )
        self.report_timer = self.create_timer(REPORT_PERIOD, self.report_callback)
        ### SKELETON
        # # TODO(task 1): create publishers of Twist on /cmd_vel and of DiagnosticArray on
        # # /diagnostics, a subscription to /scan, and a timer that calls self.report_callback.
        ### END SOLUTION
        self.get_logger().info("Profiled controller started")

    def load_model(self, path: str) -> Any | None:
        """Return the unpickled model, or ``None`` (and an error in the log) if there is none.

        Unpickling runs whatever code the file asks for: load only models that you made yourself.
        """
        ### BEGIN SOLUTION
        try:
            with open(path, "rb") as file:
                return pickle.load(file)
        except Exception as error:  # a broken pickle can raise anything
            self.get_logger().error(f"No model, so no motion: {path}: {error!r}")
            return None
        ### SKELETON
        # # TODO(task 1): load it as in exercise 2.
        # return None
        ### END SOLUTION

    def scan_callback(self, scan: LaserScan) -> None:
        """Publish exactly one Twist: the clipped prediction, or 0.0 if there is none."""
        ### BEGIN SOLUTION
        twist = Twist()
        twist.linear.x = self.choose_speed(scan)
        self.cmd_vel_publisher.publish(twist)
        ### SKELETON
        # # TODO(task 1): as in exercise 2.
        ### END SOLUTION

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the model's speed within 0 … max_speed [m/s]; 0.0 when it cannot be had."""
        ### BEGIN SOLUTION
        if self.model is None:
            return 0.0
        features = extract_features(scan)
        if features is None:
            self.get_logger().warning(
                "A sector without a usable reading: standing still", throttle_duration_sec=1.0
            )
            return 0.0
        try:
            speed = self.predict(features)
        except Exception as error:  # a model can raise anything; the node goes on
            self.get_logger().error(f"The model failed: {error!r}", throttle_duration_sec=1.0)
            return 0.0
        if not math.isfinite(speed):
            self.get_logger().warning(
                f"The model says {speed}: standing still", throttle_duration_sec=1.0
            )
            return 0.0
        return min(max(speed, 0.0), self.max_speed)
        ### SKELETON
        # # TODO(task 1): as in exercise 2, but ask self.predict.
        # return 0.0
        ### END SOLUTION

    def predict(self, features: np.ndarray) -> float:
        """Return what the model says [m/s], and keep how long it took. Raises what it raises."""
        ### BEGIN SOLUTION
        started = time.perf_counter()
        speed = float(self.model.predict(features)[0])
        # A call that raised does not get here, so it is not counted.
        self.latencies.append(1000.0 * (time.perf_counter() - started))
        return speed
        ### SKELETON
        # # TODO(task 2): measure model.predict (time.perf_counter), append to self.latencies.
        # return 0.0
        ### END SOLUTION

    def report_callback(self) -> None:
        """Publish one status about the calls in the window, every second."""
        ### BEGIN SOLUTION
        count = len(self.latencies)
        summary = latency_statistics(list(self.latencies), self.deadline)
        missed = int(summary.pop("missed"))
        level = level_of(count, missed, summary["p95_ms"], self.deadline)
        texts = {"count": str(count), "deadline_ms": f"{self.deadline:.3f}", "missed": str(missed)}
        texts |= {key: f"{number:.3f}" for key, number in summary.items()}

        status = DiagnosticStatus(name=STATUS_NAME, level=level)
        status.message = f"{missed} of {count} calls missed {self.deadline:.0f} ms"
        status.values = [KeyValue(key=key, value=text) for key, text in texts.items()]
        report = DiagnosticArray(status=[status])
        report.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics_publisher.publish(report)
        ### SKELETON
        # # TODO(task 5): one DiagnosticStatus with eight KeyValue, in a DiagnosticArray.
        ### END SOLUTION

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        ### BEGIN SOLUTION
        self.cmd_vel_publisher.publish(Twist())
        ### SKELETON
        # # TODO(task 1): publish a Twist whose fields are all 0.
        ### END SOLUTION


def main(args: list[str] | None = None) -> None:
    """Run the controller until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = ProfiledController()
    try:
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=1.0)  # a signal takes effect between two waits
    except KeyboardInterrupt:
        pass
    finally:
        node.stop()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
