"""Drives to one point, and stays there."""

import math

import rclpy
from geometry_msgs.msg import Pose, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time


class PointSeeker(Node):
    def __init__(self) -> None:
        super().__init__("point_seeker")
        self.pose: Pose | None = None
        self.measured: Time | None = None  # when it was there
        self.x = self.declare_parameter("x", 5.0).value  # [m]
        self.y = self.declare_parameter("y", 3.0).value  # [m]
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.odom_callback, qos_profile_sensor_data)
        self.create_timer(0.1, self.control_callback)

    def odom_callback(self, odom: Odometry) -> None:
        self.pose = odom.pose.pose
        self.measured = Time.from_msg(odom.header.stamp)

    def control_callback(self) -> None:
        twist = Twist()
        if self.knows_its_pose():
            dx = self.x - self.pose.position.x
            dy = self.y - self.pose.position.y
            if math.hypot(dx, dy) > 0.3:
                twist.linear.x = 0.3
                twist.angular.z = max(-1.9, min(1.9, 2.0 * self.turn(dx, dy)))
        self.publisher.publish(twist)

    def knows_its_pose(self) -> bool:
        """Has odometry come, and not fallen silent since?"""
        if self.measured is None:
            return False
        return (self.get_clock().now() - self.measured).nanoseconds < 0.5e9

    def turn(self, dx: float, dy: float) -> float:
        """Return how far to turn to face a point that is dx, dy away [rad]."""
        q = self.pose.orientation
        yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        return math.remainder(math.atan2(dy, dx) - yaw, math.tau)


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    rclpy.spin(PointSeeker())


if __name__ == "__main__":
    main()
