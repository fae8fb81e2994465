"""What was loaded says how it is asked: one generic function, an implementation for each type.

field: all
"""

import importlib
import math
import pickle
from functools import partial, singledispatch
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


@singledispatch
def ask(model, row):
    """Ask a model of scikit-learn, or what behaves like one."""
    return model.predict(row)


def load(path, device):
    """Return a function of a row of features; raises what the libraries raise."""
    match Path(path).suffix.lower():
        case ".pkl":
            model = pickle.loads(Path(path).read_bytes())
        case ".onnx":
            model = importlib.import_module("onnxruntime").InferenceSession(path)
            ask.register(type(model), ask_onnx)
        case ".pt2":
            torch = importlib.import_module("torch")
            importlib.import_module("torch.export.passes")
            program = torch.export.load(path)
            if device == "cuda":
                program = torch.export.passes.move_to_device_pass(program, device)
            model = program.module().requires_grad_(False)
            ask.register(torch.nn.Module, partial(ask_torch, torch, device))
        case ".keras":
            keras = importlib.import_module("keras")
            model = keras.saving.load_model(path)
            ask.register(keras.Model, ask_keras)
        case other:
            raise ValueError(f"a model whose suffix is {other!r}")
    return partial(ask, model)


def ask_onnx(session, row):
    outputs = session.run(None, {session.get_inputs()[0].name: row})
    return outputs[0]


def ask_torch(torch, device, module, row):
    return module(torch.asarray(row, device=device)).cpu()


def ask_keras(model, row):
    return model.predict_on_batch(row)


class PolicyController(Node):
    def __init__(self):
        super().__init__("policy_controller")
        self.path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.limit = self.declare_parameter("max_speed", 0.5).value
        device = self.declare_parameter("device", "cpu").value
        if device != "cpu" and self.path.lower().endswith(".pt2") and not self.has_gpu():
            self.get_logger().warning(f"device {device}: not here, so cpu")
            device = "cpu"
        self.policy = None
        try:
            self.policy = load(self.path, device)
        except Exception as error:
            self.get_logger().error(f"{self.path}: {type(error).__name__}: {error}")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)

    def has_gpu(self):
        try:
            return importlib.import_module("torch").cuda.is_available()
        except ImportError:
            return False

    def scan_callback(self, scan):
        twist = Twist()
        if self.policy is not None:
            twist.linear.x = self.speed(scan)
        self.cmd_vel.publish(twist)

    def speed(self, scan):
        ranges = np.array(scan.ranges, dtype=float)
        ranges = np.where(np.isneginf(ranges), scan.range_min, ranges)
        angles = scan.angle_min + np.arange(ranges.size) * scan.angle_increment
        angles = np.arctan2(np.sin(angles), np.cos(angles))
        edges = np.radians([-60.0, 60.0])
        sector = np.digitize(angles, edges)  # 0: right, 1: front, 2: left
        sector[np.isclose(angles, edges[1], atol=1e-6)] = 1
        ranges = np.ma.masked_where(~(ranges >= scan.range_min), ranges).clip(max=scan.range_max)
        right, front, left = (ranges[sector == part].compressed() for part in range(3))
        if not all(part.size for part in (right, front, left)):
            self.get_logger().warning("cannot see all around")
            return 0.0
        row = np.array([[front.min(), front.mean(), front.std(), left.min(), right.min()]])
        try:
            speed = float(np.array(self.policy(row.astype(np.float32))).flat[0])
        except Exception as error:
            self.get_logger().error(repr(error))
            return 0.0
        return max(0.0, min(speed, self.limit)) if math.isfinite(speed) else 0.0


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
