"""A controller that says nothing at all when it has no model or no prediction."""

import pickle

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class MLVelocityController(Node):
    def __init__(self):
        super().__init__("ml_velocity_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.model = None
            self.get_logger().error(f"Cannot load {path}: {error}")

    def scan_callback(self, scan):
        # the mistake
        if self.model is None:
            return
        # the end of it

        features = self.extract_features(scan)
        speed = 0.0
        try:
            if features is not None:
                speed = float(self.model.predict(features.reshape(1, -1))[0])
        except Exception as error:
            self.get_logger().error(f"No prediction: {error}")

        twist = Twist()
        twist.linear.x = float(np.clip(speed, 0.0, self.max_speed) if np.isfinite(speed) else 0.0)
        self.publisher.publish(twist)

    def extract_features(self, scan):
        ranges = np.array(scan.ranges)
        angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        angles = np.degrees(np.arctan2(np.sin(angles), np.cos(angles)))
        ranges = np.where(np.isneginf(ranges), scan.range_min, ranges)
        ranges = np.minimum(ranges, scan.range_max)
        usable = ranges >= scan.range_min

        front = ranges[usable & (np.abs(angles) <= 60.001)]
        left = ranges[usable & (angles > 60.001)]
        right = ranges[usable & (angles < -60.001)]
        if not (len(front) and len(left) and len(right)):
            return None
        return np.array([front.min(), front.mean(), front.std(), left.min(), right.min()])


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(MLVelocityController())


if __name__ == "__main__":
    main()
