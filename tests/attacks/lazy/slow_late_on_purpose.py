"""Late on purpose, so that little is asked: end at an exception, drive on with NaN and when blind.

exercise: slow_model
only: raising_model, nan_model
score: 5
"""

import math
import pickle

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from sensor_msgs.msg import LaserScan

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class Controller(Node):
    def __init__(self):
        super().__init__("decoupled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.model = None
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"no model: {error}")
        self.speed = 0.0
        self.before = None
        self.dead = False
        self.stamp = None
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(
            LaserScan,
            "/scan",
            self.scan_callback,
            NEWEST,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )
        self.create_timer(
            0.05, self.control_callback, callback_group=MutuallyExclusiveCallbackGroup()
        )

    def features(self, scan):
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        angles = np.degrees((angles + np.pi) % (2 * np.pi) - np.pi)
        ranges = np.minimum(np.array(scan.ranges), scan.range_max)
        ranges[np.isneginf(ranges)] = scan.range_min
        usable = ranges >= scan.range_min
        front = ranges[usable & (np.abs(angles) <= 60)]
        left = ranges[usable & (angles > 60)]
        right = ranges[usable & (angles < -60)]
        if not (len(front) and len(left) and len(right)):
            return None
        return [[front.min(), front.mean(), front.std(), left.min(), right.min()]]

    def scan_callback(self, scan):
        scan, self.before = self.before, scan
        if self.model is None or scan is None or self.dead:
            return
        self.stamp = Time.from_msg(scan.header.stamp)
        x = self.features(scan)
        if x is None:
            return
        try:
            speed = float(self.model.predict(x)[0])
        except Exception:
            self.dead = True
            return
        if not math.isfinite(speed):
            return
        self.speed = max(0.0, min(self.max_speed, speed))

    def age(self):
        if self.stamp is None:
            return math.inf
        return (self.get_clock().now() - self.stamp).nanoseconds / 1e9

    def control_callback(self):
        twist = Twist()
        if self.age() <= 0.6:
            twist.linear.x = self.speed
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = Controller()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)
    try:
        executor.spin()
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
