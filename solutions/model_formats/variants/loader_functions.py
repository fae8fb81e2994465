"""One loader function for each format, chosen by the suffix.

field: all
"""

import math
import os
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from numpy.typing import ArrayLike, NDArray
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

FRONT_HALF_ANGLE = math.radians(60)  # [rad] the front sector is |θ| ≤ 60°

Policy = Callable[[NDArray[np.float32]], ArrayLike]  # features (1, 5) -> speed (1,) or (1, 1) [m/s]


def scan_features(
    ranges: NDArray[np.float64],
    angles: NDArray[np.float64],
    range_min: float,
    range_max: float,
) -> NDArray[np.float32] | None:
    """Return the features (1, 5), or None where a sector is blind."""
    angles = np.remainder(angles + np.pi, 2 * np.pi) - np.pi
    ranges = np.where(ranges == -np.inf, range_min, np.minimum(ranges, range_max))
    usable = ranges >= range_min  # false for NaN
    front = ranges[usable & (np.abs(angles) <= FRONT_HALF_ANGLE)]
    left = ranges[usable & (angles > FRONT_HALF_ANGLE)]
    right = ranges[usable & (angles < -FRONT_HALF_ANGLE)]
    if not (front.size and left.size and right.size):
        return None
    row = [front.min(), front.mean(), front.std(), left.min(), right.min()]
    return np.array([row], dtype=np.float32)  # what all four formats compute with


def load_pickle(path: str) -> Policy:
    """Load a scikit-learn model. Unpickling runs code: load only models that you made yourself."""
    with open(path, "rb") as file:
        return pickle.load(file).predict


def load_onnx(path: str) -> Policy:
    """Load an ONNX model: one session, which lives as long as the node."""
    import onnxruntime

    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    name = session.get_inputs()[0].name
    return lambda features: session.run(None, {name: features})[0]


def load_torch(path: str, device: str) -> Policy:
    """Load a PyTorch program that torch.export.save wrote, onto a device."""
    import torch
    from torch.export.passes import move_to_device_pass

    model = move_to_device_pass(torch.export.load(path), device).module()

    def predict(features: NDArray[np.float32]) -> ArrayLike:
        with torch.no_grad():
            return model(torch.from_numpy(features).to(device)).cpu().numpy()

    return predict


def load_keras(path: str) -> Policy:
    """Load a Keras 3 model."""
    os.environ.setdefault("KERAS_BACKEND", "torch")  # read when Keras is imported
    import keras

    model = keras.saving.load_model(path)
    return lambda features: keras.ops.convert_to_numpy(model(features))


class PolicyController(Node):
    """Drives as a model says, whoever made it, and never trusts it blindly."""

    def __init__(self) -> None:
        super().__init__("policy_controller")
        path: str = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed: float = self.declare_parameter("max_speed", 0.5).value  # [m/s]
        self.device: str = self.declare_parameter("device", "cpu").value
        self.policy = self.load_policy(path)
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.scan_subscription = self.create_subscription(
            LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data
        )
        self.get_logger().info("Policy controller started")

    def load_policy(self, path: str) -> Policy | None:
        """Return the model in this file as a function; ``None`` and an error if there is none."""
        suffix = Path(path).suffix.lower()
        try:
            match suffix:
                case ".pkl":
                    return load_pickle(path)
                case ".onnx":
                    return load_onnx(path)
                case ".pt2":
                    return load_torch(path, self.usable_device())
                case ".keras":
                    return load_keras(path)
            raise ValueError(f"unknown suffix {suffix!r}")
        except Exception as error:  # a missing library, a missing file, a broken file: anything
            self.get_logger().error(f"No model, so no motion: {path}: {error!r}")
            return None

    def usable_device(self) -> str:
        """Return the device asked for, or ``cpu`` (and a warning) if there is no GPU."""
        import torch

        if self.device == "cuda" and not torch.cuda.is_available():
            self.get_logger().warning("No GPU that PyTorch can use: computing on the CPU")
            return "cpu"
        return self.device

    def scan_callback(self, scan: LaserScan) -> None:
        """Run the loop once: exactly one Twist for each scan."""
        twist = Twist()
        twist.linear.x = self.choose_speed(scan)
        self.cmd_vel_publisher.publish(twist)

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the policy's speed within 0 … max_speed [m/s]; 0.0 when it cannot be had."""
        if self.policy is None:
            return 0.0
        ranges = np.array(scan.ranges, dtype=float)
        angles = scan.angle_min + np.arange(len(ranges)) * scan.angle_increment
        features = scan_features(ranges, angles, scan.range_min, scan.range_max)
        if features is None:
            self.get_logger().warning("A sector without a usable reading: standing still")
            return 0.0
        try:
            speed = float(np.ravel(self.policy(features))[0])  # of (1,) and of (1, 1)
        except Exception as error:  # a model can raise anything; the node goes on
            self.get_logger().error(f"The model failed: {error!r}")
            return 0.0
        if not math.isfinite(speed):
            self.get_logger().warning(f"The model says {speed}: standing still")
            return 0.0
        return min(max(speed, 0.0), self.max_speed)


def main(args: list[str] | None = None) -> None:
    """Run the controller until Ctrl-C."""
    rclpy.init(args=args)
    node = PolicyController()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
