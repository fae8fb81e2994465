"""A class for each format, which registers itself for its suffix; each answers one number.

field: all
"""

import contextlib
import importlib
import math
import pathlib
from abc import ABC, abstractmethod

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan


class Backend(ABC):
    """A loaded model."""

    by_suffix = {}
    library = ""

    def __init_subclass__(cls, suffix):
        Backend.by_suffix[suffix] = cls

    def __init__(self, path, device, logger):
        self.device, self.logger = device, logger
        self.library = importlib.import_module(self.library)
        self.load(path)

    @abstractmethod
    def load(self, path): ...

    @abstractmethod
    def speed(self, row): ...


class Pickled(Backend, suffix=".pkl"):
    library = "pickle"

    def load(self, path):
        self.model = self.library.loads(pathlib.Path(path).read_bytes())

    def speed(self, row):
        return self.model.predict(row).item()


class Onnx(Backend, suffix=".onnx"):
    library = "onnxruntime"

    def load(self, path):
        self.session = self.library.InferenceSession(pathlib.Path(path).read_bytes())
        self.names = [given.name for given in self.session.get_inputs()]

    def speed(self, row):
        return self.session.run(None, dict(zip(self.names, [row])))[0].item()


class Torch(Backend, suffix=".pt2"):
    library = "torch"

    def load(self, path):
        torch = self.library
        if self.device == "cuda" and not torch.cuda.is_available():
            self.logger.warning("CUDA was asked for, and there is none")
            self.device = "cpu"
        with open(path, "rb") as file:
            program = torch.export.load(file)
        if self.device != "cpu":
            passes = importlib.import_module("torch.export.passes")
            program = passes.move_to_device_pass(program, self.device)
        self.module = program.module()

    def speed(self, row):
        torch = self.library
        with torch.inference_mode():
            return self.module(torch.as_tensor(row, device=self.device)).item()


class Keras(Backend, suffix=".keras"):
    library = "keras"

    def load(self, path):
        self.model = self.library.saving.load_model(path, compile=False)

    def speed(self, row):
        return self.model.predict_on_batch(row).item()


class PolicyController(Node):
    def __init__(self):
        super().__init__("policy_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        device = self.declare_parameter("device", "cpu").value
        self.backend = None
        backend = Backend.by_suffix.get(pathlib.PurePath(path).suffix.lower())
        if backend is None:
            known = ", ".join(Backend.by_suffix)
            self.get_logger().error(f"{path}: expected one of {known}")
        else:
            if device != "cpu" and not path.lower().endswith(".pt2"):
                self.get_logger().warning(f"device = {device} means nothing to {path}")
            try:
                self.backend = backend(path, device, self.get_logger())
            except Exception as error:
                self.get_logger().fatal(f"{path}: {type(error).__name__}: {error}")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 1)
        qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos)

    def scan_callback(self, scan):
        speed = 0.0
        if self.backend is not None:
            with contextlib.suppress(Exception):
                speed = self.backend.speed(self.row(scan))
        if not math.isfinite(speed):
            speed = 0.0
        twist = Twist()
        twist.linear.x = float(np.clip(speed, 0.0, self.max_speed))
        self.publisher.publish(twist)

    def row(self, scan):
        """Return (1, 5); ValueError if a sector is empty, from min()."""
        readings = np.asarray(scan.ranges, dtype=np.float64)
        degrees = np.degrees(scan.angle_min + np.arange(readings.size) * scan.angle_increment)
        degrees = (degrees + 180.0) % 360.0 - 180.0
        kept = ~np.isnan(readings) & ((readings >= scan.range_min) | np.isneginf(readings))
        readings = readings.clip(scan.range_min, scan.range_max)
        ahead = np.abs(degrees) <= 60.0
        front, left, right = (
            readings[kept & part] for part in (ahead, degrees > 60.0, degrees < -60.0)
        )
        row = [front.min(), front.mean(), front.std(), left.min(), right.min()]
        return np.asarray([row], dtype=np.float32)


def main(args=None):
    rclpy.init(args=args)
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(PolicyController())
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
