"""Drives straight ahead at one speed, and stops for a wall."""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def front_distance(scan: LaserScan) -> float | None:
    """Return the smallest usable distance within ±45° [m]; None: blind."""
    front = [
        reading
        for i, reading in enumerate(scan.ranges)
        if abs(math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)) <= math.pi / 4
    ]
    usable = [r for r in front if math.isinf(r) or scan.range_min <= r <= scan.range_max]
    return max(0.0, min(usable)) if usable else None


def choose_speed(distance: float | None) -> float:
    """Return the forward speed for a distance ahead [m/s]."""
    return 0.4 if distance is not None and distance >= 0.8 else 0.0


class WallStop(Node):
    def __init__(self) -> None:
        super().__init__("wall_stop")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)

    def scan_callback(self, scan: LaserScan) -> None:
        distance = front_distance(scan)
        speed = choose_speed(distance)
        twist = Twist()
        twist.linear.x = speed
        self.publisher.publish(twist)
        seen = "nothing usable" if distance is None else f"{distance:.2f} m"
        self.get_logger().info(f"Ahead: {seen}, velocity: {speed:.2f} m/s")


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    rclpy.spin(WallStop())


if __name__ == "__main__":
    main()
