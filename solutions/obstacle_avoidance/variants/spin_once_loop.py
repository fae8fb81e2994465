"""Style: the callback only stores the scan, a spin_once loop in main does the work.

field: field_lds01, field_wide_lidar, field_best_effort, field_mirrored_world, field_speckle,
field_lost_scans
"""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

HALF_CIRCLE = math.pi


class Eyes(Node):
    """Keeps the newest scan until somebody takes it."""

    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.scan = None
        self.create_subscription(LaserScan, "/scan", self.keep, qos_profile_sensor_data)
        self.motors = self.create_publisher(Twist, "/cmd_vel", 10)
        self.get_logger().info("Eyes open")

    def keep(self, scan):
        self.scan = scan

    def take(self):
        scan, self.scan = self.scan, None
        return scan


def perceive(scan):
    readings = []
    for i in range(len(scan.ranges)):
        angle = scan.angle_min + i * scan.angle_increment
        if angle > HALF_CIRCLE:
            angle -= 2 * HALF_CIRCLE
        reading = scan.ranges[i]
        in_limits = scan.range_min <= reading <= scan.range_max
        if abs(angle) <= HALF_CIRCLE / 2 and (in_limits or math.isinf(reading)):
            readings.append(reading)
    return min(readings) if readings else None


def decide(distance):
    if distance is None:
        return 0.0
    return 0.5 if distance >= 1.0 else 0.15 if distance >= 0.5 else 0.0


def main(args=None):
    rclpy.init(args=args)
    node = Eyes()
    try:
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=1.0)
            scan = node.take()
            if scan is None:
                continue
            distance = perceive(scan)
            twist = Twist()
            twist.linear.x = decide(distance)
            node.motors.publish(twist)
            node.get_logger().info(f"distance {distance}, velocity {twist.linear.x}")
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
