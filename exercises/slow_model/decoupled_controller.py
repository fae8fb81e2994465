"""A slow model under a fast control loop: two callback groups and an executor with two threads.

Subscribes  /scan     sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   /cmd_vel  geometry_msgs/msg/Twist    forward speed [m/s], 20 times a second
Parameters  model_path  string  a pickled model with predict(X: (n, 5)) -> (n,) [m/s]; takes 200 ms
            max_speed   double  no command is faster [m/s]
"""

import math
import pickle
import signal
from typing import Any, NamedTuple

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.time import Time
from sensor_msgs.msg import LaserScan

CONTROL_PERIOD = 0.05  # [s] 20 Hz
MAX_AGE = 0.6  # [s] a prediction whose scan is older than this is worth nothing
FRONT_HALF_ANGLE = math.radians(60.0)  # [rad] the front sector is |θ| ≤ 60°
NEWEST_ONLY = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)  # no queue of scans


class Prediction(NamedTuple):
    """What the model predicted, and from which scan."""

    speed: float  # [m/s], clipped
    stamp: Time  # of the scan


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


class DecoupledController(Node):
    """Drives at the newest prediction, 20 times a second, however long a prediction takes."""

    def __init__(self) -> None:
        super().__init__("decoupled_controller")
        model_path: str = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed: float = self.declare_parameter("max_speed", 0.5).value  # [m/s]
        self.model = self.load_model(model_path)
        # The only thing that two threads share. It is replaced as a whole, so it needs no lock.
        self.prediction: Prediction | None = None
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        # TODO(task 2): subscribe to /scan (self.scan_callback), and create a timer that calls
        # self.control_callback every CONTROL_PERIOD seconds. Which callback groups do they need?
        # Which depth does the subscription need, if no scan may wait behind another? (Or start
        # a worker thread for the model here: then the default group will do.)
        self.get_logger().info("Decoupled controller started")

    def load_model(self, path: str) -> Any | None:
        """Return the unpickled model, or ``None`` (and an error in the log) if there is none.

        Unpickling runs whatever code the file asks for: load only models that you made yourself.
        """
        # TODO(task 1): load it as in exercise 2.
        return None

    def scan_callback(self, scan: LaserScan) -> None:
        """Inference: keep the model's clipped prediction for this scan. Takes 200 ms.

        No model, a blind sector, a model that raises or returns NaN: ``self.prediction = None``.
        """
        # TODO(task 3): keep what self.choose_speed says in self.prediction, together with the
        # stamp of the *scan*.

    def choose_speed(self, scan: LaserScan) -> float | None:
        """Return the model's speed within 0 … max_speed [m/s]; ``None`` when it cannot be had."""
        # TODO(task 3): as in exercise 2. Nothing that the model does may kill the node.
        return None

    def control_callback(self) -> None:
        """Control, every 50 ms: publish the newest prediction, 0.0 if there is none or it is old.

        Old means that the scan behind it was taken more than MAX_AGE ago.
        """
        # TODO(task 4): the prediction's speed, while its scan is not too old.
        self.cmd_vel_publisher.publish(Twist())

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        self.cmd_vel_publisher.publish(Twist())


def main(args: list[str] | None = None) -> None:
    """Run the controller until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = DecoupledController()
    # TODO(task 2): this executor runs one callback at a time, which is enough with a worker
    # thread. Which one runs two?
    executor = rclpy.get_global_executor()
    executor.add_node(node)
    try:
        while rclpy.ok():
            executor.spin_once(timeout_sec=1.0)  # a signal takes effect between two waits
    except KeyboardInterrupt:
        pass
    finally:
        executor.shutdown()  # starts no further callback
        node.stop()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
