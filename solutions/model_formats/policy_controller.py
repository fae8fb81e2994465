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
    # # TODO(task 2): paste extract_features from your exercise 2; it fits as it is.
    # # Until then the model is asked about zeros, and only the checks of features fail.
    # return np.zeros((1, 5), dtype=np.float32)
    ### END SOLUTION


def load_pickle(path: str) -> Policy:
    """Load a scikit-learn model. Unpickling runs code: load only models that you made yourself."""
    ### BEGIN SOLUTION
    with open(path, "rb") as file:
        return pickle.load(file).predict
    ### SKELETON
    # # TODO(task 3): unpickle the model; its method predict is a Policy.
    # raise NotImplementedError
    ### END SOLUTION


def load_onnx(path: str) -> Policy:
    """Load an ONNX model: one session, which lives as long as the node."""
    ### BEGIN SOLUTION
    import onnxruntime

    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    name = session.get_inputs()[0].name
    return lambda features: session.run(None, {name: features})[0]
    ### SKELETON
    # # TODO(task 4): import onnxruntime here, make a session, return a function that runs it.
    # raise NotImplementedError
    ### END SOLUTION


def load_torch(path: str, device: str) -> Policy:
    """Load a PyTorch program that torch.export.save wrote, onto a device."""
    ### BEGIN SOLUTION
    import torch
    from torch.export.passes import move_to_device_pass

    model = move_to_device_pass(torch.export.load(path), device).module()

    def predict(features: NDArray[np.float32]) -> ArrayLike:
        with torch.no_grad():
            return model(torch.from_numpy(features).to(device)).cpu().numpy()

    return predict
    ### SKELETON
    # # TODO(task 5): import torch here, load the program, return a function that calls its module.
    # raise NotImplementedError
    ### END SOLUTION


def load_keras(path: str) -> Policy:
    """Load a Keras 3 model."""
    ### BEGIN SOLUTION
    os.environ.setdefault("KERAS_BACKEND", "torch")  # read when Keras is imported
    import keras

    model = keras.saving.load_model(path)
    return lambda features: keras.ops.convert_to_numpy(model(features))
    ### SKELETON
    # # TODO(task 6): import keras here, load the model, return a function that calls it.
    # raise NotImplementedError
    ### END SOLUTION


class PolicyController(Node):
    """Drives as a model says, whoever made it, and never trusts it blindly."""

    def __init__(self) -> None:
        super().__init__("policy_controller")
        ### BEGIN SOLUTION
        model_path: str = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed: float = self.declare_parameter("max_speed", 0.5).value  # [m/s]
        self.device: str = self.declare_parameter("device", "cpu").value
        self.policy = self.load_policy(model_path)
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.scan_subscription = self.create_subscription(
            LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data
        )
        ### SKELETON
        # # TODO(task 1): declare the parameters model_path, max_speed and device, create a
        # # publisher of Twist on /cmd_vel and a subscription to LaserScan on /scan.
        # # TODO(task 7): load the policy, once, here.
        # self.policy = None
        # self.max_speed = 0.5
        # self.device = "cpu"
        ### END SOLUTION
        self.get_logger().info("Policy controller started")

    def load_policy(self, path: str) -> Policy | None:
        """Return the model in this file as a function; ``None`` and an error if there is none."""
        ### BEGIN SOLUTION
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
        except Exception as error:  # a missing library, a missing file, a broken file: anything
            self.get_logger().error(f"No model, so no motion: {path}: {error!r}")
            return None
        self.get_logger().error(f"No model, so no motion: {path}: unknown suffix {suffix!r}")
        return None
        ### SKELETON
        # # TODO(task 7): choose the loader by the suffix. What if there is none, or it raises?
        # return None
        ### END SOLUTION

    def usable_device(self) -> str:
        """Return the device asked for, or ``cpu`` (and a warning) if there is no GPU."""
        ### BEGIN SOLUTION
        import torch

        if self.device == "cuda" and not torch.cuda.is_available():
            self.get_logger().warning("No GPU that PyTorch can use: computing on the CPU")
            return "cpu"
        return self.device
        ### SKELETON
        # # TODO(task 5): ask torch.cuda.is_available().
        # return self.device
        ### END SOLUTION

    def scan_callback(self, scan: LaserScan) -> None:
        """Run the loop once: exactly one Twist for each scan."""
        ### BEGIN SOLUTION
        twist = Twist()
        twist.linear.x = self.choose_speed(scan)
        self.cmd_vel_publisher.publish(twist)
        ### SKELETON
        # # TODO(task 8): publish a Twist with linear.x = self.choose_speed(scan).
        ### END SOLUTION

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the policy's speed within 0 … max_speed [m/s]; 0.0 when it cannot be had."""
        ### BEGIN SOLUTION
        if self.policy is None:
            return 0.0
        features = extract_features(scan)
        if features is None:
            self.get_logger().warning(
                "A sector without a usable reading: standing still", throttle_duration_sec=1.0
            )
            return 0.0
        try:
            speed = float(np.ravel(self.policy(features))[0])  # of (1,) and of (1, 1)
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
        # # TODO(task 8): ask the policy, and be ready for any answer.
        # return 0.0
        ### END SOLUTION

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        ### BEGIN SOLUTION
        self.cmd_vel_publisher.publish(Twist())
        ### SKELETON
        # # TODO(task 8): publish a Twist whose fields are all 0.
        ### END SOLUTION


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
