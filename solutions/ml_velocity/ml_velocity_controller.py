"""ML velocity: a trained model in the loop, between the lidar and the motors.

Subscribes  /scan     sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   /cmd_vel  geometry_msgs/msg/Twist    forward speed [m/s], one for each scan
Parameters  model_path  string  a pickled model with predict(X: (n, 5)) -> (n,) [m/s]
            max_speed   double  no command is faster [m/s]
"""

import math
import pickle
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan

FRONT_HALF_ANGLE = math.radians(60)  # [rad] the front sector is |θ| ≤ 60°


def scan_features(
    ranges: NDArray[np.float64],
    angles: NDArray[np.float64],
    range_min: float,
    range_max: float,
) -> NDArray[np.float64] | None:
    """Return what the model sees of one scan.

    Parameters
    ----------
    ranges
        (beams,) readings [m].
    angles
        (beams,) their angles [rad], 0 ahead, positive to the left, of any turn.
    range_min, range_max
        Limits of the lidar [m].

    Returns
    -------
    NDArray | None
        (5,) minimum, mean and standard deviation of the front sector, minimum of the left sector,
        minimum of the right sector [m]. ``None`` if a sector has no usable reading.
    """
    ### BEGIN SOLUTION
    angles = np.remainder(angles + np.pi, 2 * np.pi) - np.pi
    ranges = np.where(ranges == -np.inf, range_min, np.minimum(ranges, range_max))
    usable = ranges >= range_min  # false for NaN
    front = ranges[usable & (np.abs(angles) <= FRONT_HALF_ANGLE)]
    left = ranges[usable & (angles > FRONT_HALF_ANGLE)]
    right = ranges[usable & (angles < -FRONT_HALF_ANGLE)]
    if not (front.size and left.size and right.size):
        return None
    return np.array([front.min(), front.mean(), front.std(), left.min(), right.min()])
    ### SKELETON
    # # TODO(task 3): replace infinite readings, drop those that say nothing, find three sectors.
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
        # # TODO(task 2): load the model, once, here.
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
        # # TODO(task 2): unpickle the file. What if it is missing, or is no model?
        # return None
        ### END SOLUTION

    def scan_callback(self, scan: LaserScan) -> None:
        """Run the loop once: exactly one Twist for each scan."""
        ### BEGIN SOLUTION
        twist = Twist()
        twist.linear.x = self.choose_speed(scan)
        self.cmd_vel_publisher.publish(twist)
        ### SKELETON
        # # TODO(task 4): publish a Twist with linear.x = self.choose_speed(scan).
        ### END SOLUTION

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the model's speed within 0 … max_speed [m/s]; 0.0 when it cannot be had."""
        ### BEGIN SOLUTION
        if self.model is None:
            return 0.0
        ranges = np.array(scan.ranges, dtype=float)
        angles = scan.angle_min + np.arange(len(ranges)) * scan.angle_increment
        features = scan_features(ranges, angles, scan.range_min, scan.range_max)
        if features is None:
            self.get_logger().warning(
                "A sector without a usable reading: standing still", throttle_duration_sec=1.0
            )
            return 0.0
        try:
            speed = float(self.model.predict(features.reshape(1, -1))[0])
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
        # # TODO(task 4): publish a Twist whose fields are all 0.
        ### END SOLUTION


def main(args: list[str] | None = None) -> None:
    """Run the controller until Ctrl-C, then stop the robot."""
    try:
        # NO: rclpy's own Ctrl-C handler would shut ROS down before the robot can be stopped.
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        node = MlVelocityController()
        try:
            while rclpy.ok():
                rclpy.spin_once(node, timeout_sec=1.0)  # Ctrl-C takes effect between two waits
        finally:
            node.stop()
    except KeyboardInterrupt:
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
