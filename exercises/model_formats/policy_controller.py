"""Policy controller: a trained model in any of four formats, between the lidar and the motors.

Subscribes  /scan     sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   /cmd_vel  geometry_msgs/msg/Twist    forward speed [m/s], one for each scan
Parameters  model_path  string  .pkl, .onnx, .pt2 or .keras; features (n, 5) -> speeds [m/s]
            max_speed   double  no command is faster [m/s]
            device      string  cpu or cuda: where PyTorch computes
"""

import math
import os
import pickle
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from numpy.typing import ArrayLike, NDArray
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan

FRONT_HALF_ANGLE = math.radians(60.0)  # [rad] the front sector is |θ| ≤ 60°

Policy = Callable[[NDArray[np.float32]], ArrayLike]  # features (1, 5) -> speed (1,) or (1, 1) [m/s]


def extract_features(scan: LaserScan) -> np.ndarray | None:
    """Return what the model sees of a scan: one row of five features, (1, 5) float32 [m].

    Minimum, mean and population standard deviation of the front sector (|θ| ≤ 60°), minimum of
    the left sector (60° < θ ≤ 180°), minimum of the right sector (-180° ≤ θ < -60°). ``+inf`` and
    readings above ``range_max`` count as ``range_max``, ``-inf`` counts as ``range_min``; NaN and
    readings below ``range_min`` are dropped. ``None``: a sector has no usable reading.
    """
    # TODO(task 2): paste extract_features from your exercise 2; it fits as it is.
    # Until then the model is asked about zeros, and only the checks of features fail.
    return np.zeros((1, 5), dtype=np.float32)


def load_pickle(path: str) -> Policy:
    """Load a scikit-learn model. Unpickling runs code: load only models that you made yourself."""
    # TODO(task 3): unpickle the model; its method predict is a Policy.
    raise NotImplementedError


def load_onnx(path: str) -> Policy:
    """Load an ONNX model: one session, which lives as long as the node."""
    # TODO(task 4): import onnxruntime here, make a session, return a function that runs it.
    raise NotImplementedError


def load_torch(path: str, device: str) -> Policy:
    """Load a PyTorch program that torch.export.save wrote, onto a device."""
    # TODO(task 5): import torch here, load the program, return a function that calls its module.
    raise NotImplementedError


def load_keras(path: str) -> Policy:
    """Load a Keras 3 model."""
    # TODO(task 6): import keras here, load the model, return a function that calls it.
    raise NotImplementedError


class PolicyController(Node):
    """Drives as a model says, whoever made it, and never trusts it blindly."""

    def __init__(self) -> None:
        super().__init__("policy_controller")
        # TODO(task 1): declare the parameters model_path, max_speed and device, create a
        # publisher of Twist on /cmd_vel and a subscription to LaserScan on /scan.
        # TODO(task 7): load the policy, once, here.
        self.policy = None
        self.max_speed = 0.5
        self.device = "cpu"
        self.get_logger().info("Policy controller started")

    def load_policy(self, path: str) -> Policy | None:
        """Return the model in this file as a function; ``None`` and an error if there is none."""
        # TODO(task 7): choose the loader by the suffix. What if there is none, or it raises?
        return None

    def usable_device(self) -> str:
        """Return the device asked for, or ``cpu`` (and a warning) if there is no GPU."""
        # TODO(task 5): ask torch.cuda.is_available().
        return self.device

    def scan_callback(self, scan: LaserScan) -> None:
        """Run the loop once: exactly one Twist for each scan."""
        # TODO(task 8): publish a Twist with linear.x = self.choose_speed(scan).

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the policy's speed within 0 … max_speed [m/s]; 0.0 when it cannot be had."""
        # TODO(task 8): ask the policy, and be ready for any answer.
        return 0.0

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        # TODO(task 8): publish a Twist whose fields are all 0.


def main(args: list[str] | None = None) -> None:
    """Run the controller until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = PolicyController()
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
