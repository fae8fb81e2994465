"""Style: a MultiThreadedExecutor, a callback group, hand-made QoS, warms its model up, float32.

field: all
"""

import math
import pickle
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan

SCANS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=5, reliability=ReliabilityPolicy.BEST_EFFORT
)


class Blind(Exception):
    """A sector has no usable reading."""


class Controller(Node):
    def __init__(self):
        super().__init__("ml_velocity_controller")
        self.declare_parameters("", [("model_path", "velocity_model.pkl"), ("max_speed", 0.5)])
        self.predict = self._predictor(Path(self.get_parameter("model_path").value))
        self.commands = self.create_publisher(Twist, "/cmd_vel", 10)
        group = MutuallyExclusiveCallbackGroup()
        self.create_subscription(
            LaserScan, "/scan", self.scan_callback, SCANS, callback_group=group
        )

    def _predictor(self, path):
        try:
            model = pickle.loads(path.read_bytes())
            model.predict(np.ones((1, 5), np.float32))  # the first prediction is the slowest
        except Exception as error:
            if "model" not in locals():
                self.get_logger().error(f"no model in {path}: {error}")
                return lambda features: 0.0
        return lambda features: float(model.predict(features.astype(np.float32))[0])

    def scan_callback(self, scan):
        twist = Twist()
        try:
            speed = self.predict(self.features(scan))
            if math.isfinite(speed):
                limit = self.get_parameter("max_speed").value
                twist.linear.x = max(0.0, min(limit, speed))
            else:
                self.get_logger().warn(f"prediction {speed}")
        except Blind:
            self.get_logger().warn("blind")
        except Exception as error:
            self.get_logger().error(str(error))
        self.commands.publish(twist)

    def features(self, scan):
        near, far = scan.range_min, scan.range_max
        sectors = {"front": [], "left": [], "right": []}
        for i, reading in enumerate(scan.ranges):
            if math.isnan(reading) or (math.isfinite(reading) and reading < near):
                continue
            angle = math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)
            side = "left" if angle > 0 else "right"
            name = "front" if abs(angle) <= math.pi / 3 else side
            sectors[name].append(min(max(reading, near), far))
        if not all(sectors.values()):
            raise Blind
        front = np.array(sectors["front"])
        return np.array(
            [
                [
                    front.min(),
                    front.mean(),
                    math.sqrt(np.mean((front - front.mean()) ** 2)),
                    min(sectors["left"]),
                    min(sectors["right"]),
                ]
            ]
        )


def main(args=None):
    rclpy.init(args=args)
    node = Controller()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        node.commands.publish(Twist())
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
