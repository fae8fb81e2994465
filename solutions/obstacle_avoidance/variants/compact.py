"""As little code as the contract allows.

field: all
"""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.get_logger().info("Obstacle avoidance agent started")

    def perceive(self, scan):
        readings = []
        for i, r in enumerate(scan.ranges):
            angle = math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)
            if abs(angle) > math.pi / 2:
                continue
            if r == -math.inf:
                readings.append(0.0)
            elif r == math.inf or scan.range_min <= r <= scan.range_max:
                readings.append(r)
        return min(readings, default=None)

    def decide(self, distance):
        if distance is None or distance < 0.5:
            return 0.0
        if distance < 1.0:
            return 0.15
        return 0.5

    def scan_callback(self, scan):
        twist = Twist()
        twist.linear.x = self.decide(self.perceive(scan))
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = Agent()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
