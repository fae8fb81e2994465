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
        ### BEGIN SOLUTION
        # Callbacks of different groups may run at the same time, those of one group never do: one
        # inference at a time. With a depth of 1 the next one takes the newest scan there is.
        self.scan_subscription = self.create_subscription(
            LaserScan,
            "/scan",
            self.scan_callback,
            NEWEST_ONLY,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )
        self.control_timer = self.create_timer(
            CONTROL_PERIOD, self.control_callback, callback_group=MutuallyExclusiveCallbackGroup()
        )
        ### SKELETON
        # # TODO(task 2): subscribe to /scan (self.scan_callback), and create a timer that calls
        # # self.control_callback every CONTROL_PERIOD seconds. Which callback groups do they need?
        # # Which depth does the subscription need, if no scan may wait behind another? (Or start
        # # a worker thread for the model here: then the default group will do.)
        ### END SOLUTION
        self.get_logger().info("Decoupled controller started")

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
        """Inference: keep the model's clipped prediction for this scan. Takes 200 ms.

        No model, a blind sector, a model that raises or returns NaN: ``self.prediction = None``.
        """
        ### BEGIN SOLUTION
        speed = self.choose_speed(scan)
        stamp = Time.from_msg(scan.header.stamp)
        self.prediction = None if speed is None else Prediction(speed, stamp)
        ### SKELETON
        # # TODO(task 3): keep what self.choose_speed says in self.prediction, together with the
        # # stamp of the *scan*.
        ### END SOLUTION

    def choose_speed(self, scan: LaserScan) -> float | None:
        """Return the model's speed within 0 … max_speed [m/s]; ``None`` when it cannot be had."""
        ### BEGIN SOLUTION
        if self.model is None:
            return None
        features = extract_features(scan)
        if features is None:
            self.get_logger().warning(
                "A sector without a usable reading: no prediction", throttle_duration_sec=1.0
            )
            return None
        try:
            speed = float(self.model.predict(features)[0])
        except Exception as error:  # a model can raise anything; the node goes on
            self.get_logger().error(f"The model failed: {error!r}", throttle_duration_sec=1.0)
            return None
        if not math.isfinite(speed):
            self.get_logger().warning(f"The model says {speed}", throttle_duration_sec=1.0)
            return None
        return min(max(speed, 0.0), self.max_speed)
        ### SKELETON
        # # TODO(task 3): as in exercise 2. Nothing that the model does may kill the node.
        # return None
        ### END SOLUTION

    def control_callback(self) -> None:
        """Control, every 50 ms: publish the newest prediction, 0.0 if there is none or it is old.

        Old means that the scan behind it was taken more than MAX_AGE ago.
        """
        ### BEGIN SOLUTION
        twist = Twist()
        prediction = self.prediction  # once: the other thread may replace it at any time
        if prediction is not None:
            age = (self.get_clock().now() - prediction.stamp).nanoseconds / 1e9  # [s]
            if age <= MAX_AGE:
                twist.linear.x = prediction.speed
        self.cmd_vel_publisher.publish(twist)
        ### SKELETON
        # # TODO(task 4): the prediction's speed, while its scan is not too old.
        # self.cmd_vel_publisher.publish(Twist())
        ### END SOLUTION

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        self.cmd_vel_publisher.publish(Twist())


def main(args: list[str] | None = None) -> None:
    """Run the controller until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = DecoupledController()
    ### BEGIN SOLUTION
    executor = MultiThreadedExecutor(num_threads=2)  # one for inference, one for control
    ### SKELETON
    # # TODO(task 2): this executor runs one callback at a time, which is enough with a worker
    # # thread. Which one runs two?
    # executor = rclpy.get_global_executor()
    ### END SOLUTION
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
