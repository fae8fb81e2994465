"""The distance ahead is the min() of whatever the lidar sent."""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class ObstacleAvoidanceAgent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.get_logger().info("Obstacle avoidance agent started")

    def scan_callback(self, scan):
        front = [
            r
            for i, r in enumerate(scan.ranges)
            if math.cos(scan.angle_min + i * scan.angle_increment) >= -1e-6
        ]

        # the mistake
        distance = min(front)
        # the end of it

        if distance < 0.5:
            speed = 0.0
        elif distance < 1.0:
            speed = 0.15
        else:
            speed = 0.5

        twist = Twist()
        twist.linear.x = speed
        self.publisher.publish(twist)
        self.get_logger().info(f"Distance: {distance:.2f} m, velocity: {speed:.2f} m/s")


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(ObstacleAvoidanceAgent())


if __name__ == "__main__":
    main()
