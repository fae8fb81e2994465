"""A trained model in the loop: what is ahead goes in, a speed comes out."""

import math
import pickle

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

FRONT = np.radians(60)  # ahead is |angle| <= 60°


def extract_features(scan: LaserScan) -> NDArray[np.float32] | None:
    """Return front min, mean, std [m]; None: blind."""
    ranges = np.array(scan.ranges)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    angles = np.remainder(angles + np.pi, 2 * np.pi) - np.pi
    ranges = np.where(ranges == -np.inf, scan.range_min, np.minimum(ranges, scan.range_max))
    usable = ranges >= scan.range_min  # false for NaN
    front = ranges[usable & (np.abs(angles) <= FRONT)]
    if not front.size:
        return None
    return np.array([[front.min(), front.mean(), front.std()]], dtype=np.float32)


class ModelDriver(Node):
    def __init__(self) -> None:
        super().__init__("model_driver")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value  # [m/s]
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.model = None
            self.get_logger().error(f"No model: {path}: {error!r}")

    def scan_callback(self, scan: LaserScan) -> None:
        twist = Twist()
        if self.model is not None:
            twist.linear.x = self.choose_speed(scan)
        self.publisher.publish(twist)

    def choose_speed(self, scan: LaserScan) -> float:
        """Return the model's speed [m/s], within 0 … max_speed."""
        features = extract_features(scan)
        if features is None:
            self.get_logger().warning("Nothing usable ahead: standing still")
            return 0.0
        try:
            speed = float(self.model.predict(features)[0])
        except Exception as error:
            self.get_logger().error(f"The model failed: {error!r}")
            return 0.0
        if not math.isfinite(speed):
            self.get_logger().error(f"The model says {speed}: standing still")
            return 0.0
        return float(np.clip(speed, 0.0, self.max_speed))


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    rclpy.spin(ModelDriver())


if __name__ == "__main__":
    main()
