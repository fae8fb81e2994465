"""All libraries at the top, each in a try of its own; what is missing is None.

field: all
"""

import os
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSPresetProfiles
from sensor_msgs.msg import LaserScan

os.environ.setdefault("KERAS_BACKEND", "torch")
try:
    import joblib
except ImportError:
    joblib = None
try:
    import onnxruntime
except ImportError:
    onnxruntime = None
try:
    import torch
except ImportError:
    torch = None
try:
    import keras
except ImportError:
    keras = None


class NoPolicy(Exception):
    """There is nothing to drive with."""


class PolicyController(Node):
    def __init__(self):
        super().__init__("policy_controller")
        self.declare_parameters(
            "", [("model_path", "velocity_model.pkl"), ("max_speed", 0.5), ("device", "cpu")]
        )
        path, self.max_speed, self.device = (
            self.get_parameter(name).value for name in ("model_path", "max_speed", "device")
        )
        try:
            self.model, self.predict = self.open(path)
            self.predict(np.ones((1, 5), np.float32))  # warm up: the first call is the slowest
        except NoPolicy as error:
            self.predict = None
            self.get_logger().error(f"{path}: {error}")
        except Exception as error:
            self.get_logger().warning(f"{path}: no luck with a first prediction: {error}")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 5)
        self.create_subscription(
            LaserScan, "/scan", self.scan_callback, QoSPresetProfiles.SENSOR_DATA.value
        )

    def open(self, path):
        """Return the model and a method of this node that asks it."""
        suffix = Path(path.lower()).suffix
        kinds = {
            ".pkl": (joblib, self.load_pickle, self.ask_pickle),
            ".onnx": (onnxruntime, self.load_onnx, self.ask_onnx),
            ".pt2": (torch, self.load_torch, self.ask_torch),
            ".keras": (keras, self.load_keras, self.ask_keras),
        }
        if suffix not in kinds:
            raise NoPolicy(f"not one of {sorted(kinds)}")
        library, load, ask = kinds[suffix]
        if library is None:
            raise NoPolicy("its library is not installed")
        try:
            return load(path), ask
        except Exception as error:
            raise NoPolicy(f"cannot be loaded: {error!r}") from error

    def load_pickle(self, path):
        return joblib.load(path)

    def ask_pickle(self, row):
        return self.model.predict(row)

    def load_onnx(self, path):
        return onnxruntime.InferenceSession(path, providers=onnxruntime.get_available_providers())

    def ask_onnx(self, row):
        return self.model.run(None, {self.model.get_inputs()[0].name: row})[0]

    def load_torch(self, path):
        program = torch.export.load(path)
        if self.device.startswith("cuda"):
            if torch.cuda.device_count():
                program = torch.export.passes.move_to_device_pass(program, self.device)
            else:
                self.get_logger().warning(f"{self.device}: not on this machine; taking the CPU")
                self.device = "cpu"
        return program.module()

    def ask_torch(self, row):
        return self.model(torch.from_numpy(row).to(self.device)).detach().cpu()

    def load_keras(self, path):
        return keras.models.load_model(path)

    def ask_keras(self, row):
        return self.model.predict(row, verbose=0)

    def scan_callback(self, scan):
        twist = Twist()
        row = None if self.predict is None else features(scan)
        if row is not None:
            try:
                speed = np.asarray(self.predict(row), dtype=np.float64).ravel()[0]
                if np.isfinite(speed):
                    twist.linear.x = float(min(max(0.0, speed), self.max_speed))
            except Exception as error:
                self.get_logger().error(f"no prediction: {error}")
        self.publisher.publish(twist)


def features(scan):
    ranges = np.array(scan.ranges, dtype=np.float32)
    low, high = np.float32(scan.range_min), np.float32(scan.range_max)
    turn = np.exp(1j * (scan.angle_min + scan.angle_increment * np.arange(ranges.size)))
    ranges[np.isneginf(ranges)] = low
    usable = ranges >= low
    ranges = np.minimum(ranges, high).astype(np.float64)
    ahead = turn.real >= np.cos(np.radians(60.0)) - 1e-9
    front = ranges[usable & ahead]
    left = ranges[usable & ~ahead & (turn.imag >= 0)]
    right = ranges[usable & ~ahead & (turn.imag < 0)]
    if min(front.size, left.size, right.size) == 0:
        return None
    spread = np.sqrt(np.mean((front - front.mean()) ** 2))
    return np.array([[front.min(), front.mean(), spread, left.min(), right.min()]], np.float32)


def main(args=None):
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
