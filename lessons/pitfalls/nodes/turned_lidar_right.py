"""Drives straight ahead at one speed, and stops for a wall."""

import math

import rclpy
from geometry_msgs.msg import Quaternion, Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from tf2_ros import Buffer, TransformException, TransformListener


def yaw_of(q: Quaternion) -> float:
    """Return how far a rotation turns to the left [rad]."""
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))


def front_distance(scan: LaserScan, yaw: float) -> float | None:
    """Return the smallest usable distance within ±45° of the robot's front [m]; None: blind."""
    first = scan.angle_min + yaw  # [rad] on the robot
    front = [
        reading
        for i, reading in enumerate(scan.ranges)
        if abs(math.remainder(first + i * scan.angle_increment, math.tau)) <= math.pi / 4
    ]
    usable = [r for r in front if math.isinf(r) or scan.range_min <= r <= scan.range_max]
    return max(0.0, min(usable)) if usable else None


def choose_speed(distance: float | None) -> float:
    """Return the forward speed for a distance ahead [m/s]."""
    return 0.4 if distance is not None and distance >= 0.8 else 0.0


class WallStop(Node):
    def __init__(self) -> None:
        super().__init__("wall_stop")
        self.frames = Buffer()
        self.listener = TransformListener(self.frames, self)
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)

    def mounted(self, frame: str) -> float | None:
        """Return how far a sensor is turned on the robot [rad]; None: nobody has said yet."""
        try:
            mount = self.frames.lookup_transform("base_link", frame, Time())
        except TransformException:
            return None
        return yaw_of(mount.transform.rotation)

    def scan_callback(self, scan: LaserScan) -> None:
        yaw = self.mounted(scan.header.frame_id)
        distance = None if yaw is None else front_distance(scan, yaw)
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
