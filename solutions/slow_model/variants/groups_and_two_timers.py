"""Style: three callback groups and a MultiThreadedExecutor; inference has a timer of its own.

field: all
"""

import math
import pickle
from threading import Lock

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan


class DecoupledController(Node):
    MAX_AGE = Duration(seconds=0.6)

    def __init__(self) -> None:
        super().__init__("decoupled_controller")
        self.lock = Lock()
        self.scan = None
        self.prediction = 0.0
        self.predicted_from = None
        self.max_speed = self.declare_parameter("max_speed", 0.5).get_parameter_value().double_value
        self.model = self.load()
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        always = ReentrantCallbackGroup()
        self.create_subscription(
            LaserScan,
            "/scan",
            self.on_scan,
            qos_profile_sensor_data,
            callback_group=always,
        )
        self.create_timer(0.05, self.on_control, callback_group=MutuallyExclusiveCallbackGroup())
        self.create_timer(0.02, self.on_inference, callback_group=MutuallyExclusiveCallbackGroup())

    def load(self):
        path = self.declare_parameter("model_path", "velocity_model.pkl")
        try:
            with open(path.get_parameter_value().string_value, "rb") as file:
                return pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"model not loaded: {error}")
            return None

    def on_scan(self, scan: LaserScan) -> None:
        with self.lock:
            self.scan = scan

    def on_inference(self) -> None:
        with self.lock:
            scan, self.scan = self.scan, None
        if scan is None or self.model is None:
            return
        try:
            speed = float(np.squeeze(self.model.predict(self.features(scan))))
        except Exception as error:
            speed = math.nan
            self.get_logger().error(f"inference: {error}")
        with self.lock:
            if math.isnan(speed) or math.isinf(speed):
                self.predicted_from = None
            else:
                self.prediction = min(max(0.0, speed), self.max_speed)
                self.predicted_from = Time.from_msg(scan.header.stamp)

    def on_control(self) -> None:
        twist = Twist()
        with self.lock:
            if self.predicted_from is not None:
                if self.get_clock().now() - self.predicted_from <= self.MAX_AGE:
                    twist.linear.x = self.prediction
        self.publisher.publish(twist)

    @staticmethod
    def features(scan: LaserScan) -> np.ndarray:
        ranges = np.array(scan.ranges, dtype=np.float32)
        angles = np.linspace(
            scan.angle_min,
            scan.angle_min + scan.angle_increment * (len(ranges) - 1),
            len(ranges),
        )
        angles = np.where(angles > np.pi, angles - 2 * np.pi, angles)
        ranges[np.isneginf(ranges)] = scan.range_min
        ranges = np.minimum(ranges, np.float32(scan.range_max))
        good = ranges >= np.float32(scan.range_min)
        front = ranges[good & (np.abs(angles) <= np.pi / 3)]
        left = ranges[good & (angles > np.pi / 3)]
        right = ranges[good & (angles < -np.pi / 3)]
        return np.array([[front.min(), front.mean(), front.std(), left.min(), right.min()]])


def main(args=None) -> None:
    rclpy.init(args=args)
    node = DecoupledController()
    executor = MultiThreadedExecutor(num_threads=4)
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
