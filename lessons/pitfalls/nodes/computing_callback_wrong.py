"""A model chooses the speed, and a quick rule has the last word: it stops for a wall."""

import math
import time

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from sensor_msgs.msg import LaserScan

NEWEST_SCAN = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


def predict(scan: LaserScan) -> float:
    """Return the forward speed for a room of this size [m/s]."""
    time.sleep(0.51)  # stands for a large network
    return 0.5 if max(scan.ranges, default=0.0) > 3.0 else 0.2


def front_distance(scan: LaserScan) -> float | None:
    """Return the smallest usable distance within ±45° [m]; None: blind."""
    front = [
        reading
        for i, reading in enumerate(scan.ranges)
        if abs(math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)) <= math.pi / 4
    ]
    usable = [r for r in front if math.isinf(r) or scan.range_min <= r <= scan.range_max]
    return max(0.0, min(usable)) if usable else None


class CarefulDriver(Node):
    def __init__(self) -> None:
        super().__init__("careful_driver")
        self.scan: LaserScan | None = None  # the newest
        self.said: tuple[float, LaserScan] | None = None  # the newest prediction [m/s], and of what
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, NEWEST_SCAN)
        self.create_timer(0.05, self.control_callback)

    def scan_callback(self, scan: LaserScan) -> None:
        self.scan = scan
        self.said = predict(scan), scan

    def control_callback(self) -> None:
        scan, said = self.scan, self.said
        command = Twist()
        if scan is not None and said is not None and self.age(scan) < 0.75:
            distance, (speed, seen) = front_distance(scan), said
            if distance is not None and distance >= 0.8 and self.age(seen) < 1.5:
                command.linear.x = speed
        self.publisher.publish(command)

    def age(self, scan: LaserScan) -> float:
        """Return how long ago a scan was measured [s]."""
        return (self.get_clock().now() - Time.from_msg(scan.header.stamp)).nanoseconds / 1e9


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    rclpy.spin(CarefulDriver())


if __name__ == "__main__":
    main()
