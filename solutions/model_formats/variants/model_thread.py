"""A thread of its own loads the model and asks it; callbacks wait for its answers.

field: all
"""

import math
import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

SIXTY = math.pi / 3


class Policy:
    """Lives in one thread: some libraries do not like to be asked from another."""

    def __init__(self, path, device, logger):
        self.logger = logger
        self.thread = ThreadPoolExecutor(max_workers=1)
        self.ask = self.thread.submit(self.load, path, device).result()

    def load(self, path, device):
        suffix = Path(path).suffix.casefold()
        if suffix == ".pkl":
            with Path(path).open("rb") as file:
                return pickle.Unpickler(file).load().predict
        if suffix == ".onnx":
            import onnxruntime as ort

            session = ort.InferenceSession(path, providers=["CPUExecutionProvider"])
            (given, *_) = session.get_inputs()
            return lambda row: session.run(None, {given.name: row})[0]
        if suffix == ".pt2":
            return self.load_torch(path, device)
        if suffix == ".keras":
            import keras

            model = keras.saving.load_model(path)
            return lambda row: model(row).detach().cpu().numpy()
        raise ValueError(f"{path} has the suffix {suffix or 'of nothing'}")

    def load_torch(self, path, device):
        import torch

        if device == "cuda" and not torch.cuda.is_available():
            self.logger.warning("device cuda: falling back to the CPU")
            device = "cpu"
        module = torch.export.load(path).module()
        if device == "cuda":
            module.to("cuda")
        torch.set_grad_enabled(False)  # of this thread
        return lambda row: module(torch.tensor(row, device=device)).cpu().numpy()

    def speed(self, row):
        answer = self.thread.submit(self.ask, row).result()
        return float(answer.reshape(-1)[0])


class PolicyController(Node):
    def __init__(self):
        super().__init__("policy_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        device = self.declare_parameter("device", "cpu").value
        try:
            self.policy = Policy(path, device, self.get_logger())
        except Exception as error:
            self.policy = None
            self.get_logger().error(f"no policy: {error!r}")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(
            LaserScan,
            "/scan",
            self.scan_callback,
            qos_profile_sensor_data,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )

    def scan_callback(self, scan):
        try:
            speed = self.speed(scan)
        except Exception as error:
            self.get_logger().error(f"standing still: {error!r}")
            speed = 0.0
        self.publisher.publish(twist_of(speed))

    def speed(self, scan):
        row = features(scan)
        if self.policy is None or row is None:
            return 0.0
        speed = self.policy.speed(row)
        return min(max(speed, 0.0), self.max_speed) if math.isfinite(speed) else 0.0


def twist_of(speed):
    twist = Twist()
    twist.linear.x = speed
    return twist


def features(scan):
    usable = []
    for i, reading in enumerate(scan.ranges):
        clipped = min(max(reading, scan.range_min), scan.range_max)
        if reading >= scan.range_min or reading == -math.inf:
            angle = scan.angle_min + i * scan.angle_increment
            usable.append((math.atan2(math.sin(angle), math.cos(angle)), clipped))
    front = np.array([r for angle, r in usable if -SIXTY <= angle <= SIXTY])
    left = [r for angle, r in usable if angle > SIXTY]
    right = [r for angle, r in usable if angle < -SIXTY]
    if not (len(front) and left and right):
        return None
    row = [front.min(), front.mean(), front.std(), min(left), min(right)]
    return np.array(row, dtype=np.float32).reshape(1, 5)


def main(args=None):
    rclpy.init(args=args)
    node = PolicyController()
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
