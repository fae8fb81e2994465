"""Style: the other way round; rclpy.spin runs inference, and a thread of its own the control loop.

field: all
"""

import math
import pickle
import threading
import time

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan

PERIOD = 0.05


class DecoupledController(Node):
    def __init__(self) -> None:
        super().__init__("decoupled_controller")
        self.declare_parameter("model_path", "velocity_model.pkl")
        self.declare_parameter("max_speed", 0.5)
        self.model = None
        path = self.get_parameter("model_path").value
        try:
            self.model = pickle.loads(open(path, "rb").read())
        except Exception as error:
            self.get_logger().error(f"{path}: {error}")
        self.state = (0.0, 0.0)
        self.pub = self.create_publisher(Twist, "/cmd_vel", 1)
        newest = QoSProfile(
            history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT
        )
        self.sub = self.create_subscription(LaserScan, "/scan", self.infer, newest)

    def infer(self, scan: LaserScan) -> None:
        if self.model is None:
            return
        stamp = scan.header.stamp.sec + 1e-9 * scan.header.stamp.nanosec
        try:
            prediction = float(self.model.predict(features(scan))[0])
        except Exception as error:
            self.get_logger().warn(f"{error}")
            prediction = math.nan
        limit = self.get_parameter("max_speed").value
        if math.isfinite(prediction):
            self.state = (max(0.0, min(limit, prediction)), stamp)
        else:
            self.state = (0.0, stamp)

    def control_for_ever(self) -> None:
        due = time.monotonic()
        while rclpy.ok():
            speed, stamp = self.state
            now = self.get_clock().now().nanoseconds * 1e-9
            twist = Twist()
            twist.linear.x = speed if now - stamp < 0.6 else 0.0
            self.pub.publish(twist)
            due += PERIOD
            time.sleep(max(0.0, due - time.monotonic()))


def features(scan: LaserScan) -> np.ndarray:
    kept: dict[int, list[float]] = {-1: [], 0: [], 1: []}
    for i, value in enumerate(scan.ranges):
        if value != value:
            continue
        value = scan.range_min if value == -math.inf else min(value, scan.range_max)
        if value >= scan.range_min:
            turn = scan.angle_min + scan.angle_increment * i
            x, y = math.cos(turn), math.sin(turn)
            kept[0 if x >= 0.5 - 1e-9 else 1 if y > 0 else -1].append(value)
    front = np.array(kept[0])
    return np.array([[front.min(), front.mean(), front.std(), min(kept[1]), min(kept[-1])]])


def main(args=None) -> None:
    rclpy.init(args=args)
    node = DecoupledController()
    threading.Thread(target=node.control_for_ever, daemon=True).start()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
