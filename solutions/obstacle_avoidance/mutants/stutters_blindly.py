"""Never looks at the scan: creeps on, a little faster and slower by turns.

fails: clear_zone, slow_zone, stop_zone, ignores_behind, sees_sides, infinite_readings, invalid_readings, minus_infinity, blind, no_contact, drives_on
"""  # noqa: E501

import itertools

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.speeds = itertools.cycle((0.03, 0.07))
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)

    def scan_callback(self, scan):
        twist = Twist()
        twist.linear.x = next(self.speeds)
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
