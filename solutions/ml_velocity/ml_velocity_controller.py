"""ML velocity: a trained model in the loop, between the lidar and the motors.

Subscribes  /scan     sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   /cmd_vel  geometry_msgs/msg/Twist    forward speed [m/s], one for each scan
Parameters  model_path  string  a pickled model with predict(X: (n, 5)) -> (n,) [m/s]
            max_speed   double  no command is faster [m/s]
"""

import math
import pickle
import signal
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan

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
    # # TODO(task 4): replace infinite readings, drop those that say nothing, find three sectors.
    # return None
    ### END SOLUTION


class MlVelocityController(Node):
    """Lets a trained model choose the forward speed, and never trusts it blindly."""

    def __init__(self) -> None:
        super().__init__("ml_velocity_controller")
        ### BEGIN SOLUTION
        model_path: str = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed: float = self.declare_parameter("max_speed", 0.5).value  # [m/s]
        self.model = self.load_model(model_path)
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.scan_subscription = self.create_subscription(
            LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data
        )
        ### SKELETON
        # # TODO(task 1): declare the parameters model_path and max_speed, create a publisher of
        # # Twist on /cmd_vel and a subscription to LaserScan on /scan.
        # # TODO(task 3): load the model, once, here.
        # self.model = None
        # self.max_speed = 0.5
        ### END SOLUTION
        self.get_logger().info("ML velocity controller started")

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
        # # TODO(task 3): unpickle the file. What if it is missing, or not a model?
        # return None
        ### END SOLUTION

    def scan_callback(self, scan: LaserScan) -> None:
        """Run the loop once: exactly one Twist for each scan."""
        ### BEGIN SOLUTION
        twist = Twist()
        twist.linear.x = self.choose_speed(scan)
        self.cmd_vel_publisher.publish(twist)
        ### SKELETON
        # # TODO(task 2): publish a Twist with linear.x = self.choose_speed(scan).
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
            speed = float(self.model.predict(features)[0])
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
        # # TODO(task 5): ask the model, and be ready for any answer.
        # return 0.0
        ### END SOLUTION

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        ### BEGIN SOLUTION
        self.cmd_vel_publisher.publish(Twist())
        ### SKELETON
        # # TODO(task 2): publish a Twist whose fields are all 0.
        ### END SOLUTION


def main(args: list[str] | None = None) -> None:
    """Run the controller until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = MlVelocityController()
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
