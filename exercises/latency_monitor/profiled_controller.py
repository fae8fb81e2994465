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
    # TODO(task 1): paste extract_features from your exercise 2; it fits as it is.
    # Until then the model is asked about zeros, and only the checks of features fail.
    return np.zeros((1, 5), dtype=np.float32)


def latency_statistics(latencies: list[float], deadline: float) -> dict[str, float]:
    """Return mean, percentiles, maximum [ms] and the number of missed deadlines of latencies [ms].

    Percentiles lie between two measurements (linear interpolation). Without any measurement
    everything is 0.0.
    """
    # TODO(task 3): numpy.mean, numpy.percentile, max, and a count.
    names = ("mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms", "missed")
    return dict.fromkeys(names, 0.0)


def level_of(count: int, missed: float, p95: float, deadline: float) -> bytes:
    """Return the level: STALE without a prediction, OK, WARN (some missed), ERROR (p95 too)."""
    # TODO(task 4): compare, and return one of the constants of DiagnosticStatus.
    return DiagnosticStatus.STALE


class ProfiledController(Node):
    """Drives as the model says, and knows how long the model takes to say it."""

    def __init__(self) -> None:
        super().__init__("profiled_controller")
        model_path: str = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed: float = self.declare_parameter("max_speed", 0.5).value  # [m/s]
        self.deadline: float = self.declare_parameter("deadline_ms", 100.0).value  # [ms]
        self.model = self.load_model(model_path)
        self.latencies: deque[float] = deque(maxlen=WINDOW)  # [ms] of the last calls
        # TODO(task 1): create publishers of Twist on /cmd_vel and of DiagnosticArray on
        # /diagnostics, a subscription to /scan, and a timer that calls self.report_callback.
        self.get_logger().info("Profiled controller started")

    def load_model(self, path: str) -> Any | None:
        """Return the unpickled model, or ``None`` (and an error in the log) if there is none.

        Unpickling runs whatever code the file asks for: load only models that you made yourself.
        """
        # TODO(task 1): load it as in exercise 2.
        return None

    def scan_callback(self, scan: LaserScan) -> None:
        """Publish exactly one Twist: the clipped prediction, or 0.0 if there is none."""
        # TODO(task 1): as in exercise 2.

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the model's speed within 0 … max_speed [m/s]; 0.0 when it cannot be had."""
        # TODO(task 1): as in exercise 2, but ask self.predict.
        return 0.0

    def predict(self, features: np.ndarray) -> float:
        """Return what the model says [m/s], and keep how long it took. Raises what it raises."""
        # TODO(task 2): measure model.predict (time.perf_counter), append to self.latencies.
        return 0.0

    def report_callback(self) -> None:
        """Publish one status about the calls in the window, every second."""
        # TODO(task 5): one DiagnosticStatus with eight KeyValue, in a DiagnosticArray.

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        # TODO(task 1): publish a Twist whose fields are all 0.


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
