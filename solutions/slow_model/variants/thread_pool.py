"""Style: concurrent.futures; the control loop itself hands the newest scan to a pool of one.

field: all
"""

import math
import pickle
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def infer(model, scan: LaserScan) -> float:
    """Run in the pool: features, prediction. Raises when there is nothing to say."""
    angles = np.angle(
        np.exp(1j * (scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))))
    )
    ranges = np.clip(np.array(scan.ranges, dtype=float), None, scan.range_max)
    ranges[ranges == -math.inf] = scan.range_min
    ranges[ranges < scan.range_min] = math.nan
    limit = math.radians(60)
    front = ranges[np.abs(angles) <= limit]
    row = [
        np.nanmin(front),
        np.nanmean(front),
        np.nanstd(front),
        np.nanmin(ranges[angles > limit]),
        np.nanmin(ranges[angles < -limit]),
    ]
    if np.isnan(row).any():
        raise ValueError("a sector has no usable reading")
    return float(model.predict(np.array(row).reshape(1, -1))[0])


class DecoupledController(Node):
    def __init__(self) -> None:
        super().__init__("decoupled_controller")
        self.declare_parameters("", [("model_path", "velocity_model.pkl"), ("max_speed", 0.5)])
        self.max_speed = self.get_parameter("max_speed").value
        self.pool = ThreadPoolExecutor(max_workers=1)
        self.scan: LaserScan | None = None  # newest, not yet given to the model
        self.running: tuple[Future, LaserScan] | None = None
        self.speed = 0.0
        self.seen: LaserScan | None = None  # the scan behind the speed
        try:
            with open(self.get_parameter("model_path").value, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.model = None
            self.get_logger().error(f"no model: {error}")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.create_timer(0.05, self.control_callback)

    def scan_callback(self, scan: LaserScan) -> None:
        self.scan = scan

    def control_callback(self) -> None:
        self.collect()
        if self.running is None and self.scan is not None and self.model is not None:
            self.running = (self.pool.submit(infer, self.model, self.scan), self.scan)
            self.scan = None
        twist = Twist()
        if self.seen is not None and self.age_of(self.seen) <= 0.6:
            twist.linear.x = self.speed
        self.publisher.publish(twist)

    def collect(self) -> None:
        if self.running is None or not self.running[0].done():
            return
        future, scan = self.running
        self.running = None
        if future.exception() is not None or not math.isfinite(future.result()):
            self.get_logger().error(f"no prediction: {future}")
            self.seen = None
            return
        self.speed, self.seen = sorted((0.0, future.result(), self.max_speed))[1], scan

    def age_of(self, scan: LaserScan) -> float:
        stamp = scan.header.stamp
        return self.get_clock().now().nanoseconds / 1e9 - stamp.sec - stamp.nanosec / 1e9


def main(args=None) -> None:
    rclpy.init(args=args)
    node = DecoupledController()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.pool.shutdown(cancel_futures=True)
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
