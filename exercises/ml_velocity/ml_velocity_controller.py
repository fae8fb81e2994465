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
    # TODO(task 4): replace infinite readings, drop those that say nothing, find three sectors.
    return None


class MlVelocityController(Node):
    """Lets a trained model choose the forward speed, and never trusts it blindly."""

    def __init__(self) -> None:
        super().__init__("ml_velocity_controller")
        # TODO(task 1): declare the parameters model_path and max_speed, create a publisher of
        # Twist on /cmd_vel and a subscription to LaserScan on /scan.
        # TODO(task 3): load the model, once, here.
        self.model = None
        self.max_speed = 0.5
        self.get_logger().info("ML velocity controller started")

    def load_model(self, path: str) -> Any | None:
        """Return the unpickled model, or ``None`` (and an error in the log) if there is none.

        Unpickling runs whatever code the file asks for: load only models that you made yourself.
        """
        # TODO(task 3): unpickle the file. What if it is missing, or not a model?
        return None

    def scan_callback(self, scan: LaserScan) -> None:
        """Run the loop once: exactly one Twist for each scan."""
        # TODO(task 2): publish a Twist with linear.x = self.choose_speed(scan).

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the model's speed within 0 … max_speed [m/s]; 0.0 when it cannot be had."""
        # TODO(task 5): ask the model, and be ready for any answer.
        return 0.0

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        # TODO(task 2): publish a Twist whose fields are all 0.


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
