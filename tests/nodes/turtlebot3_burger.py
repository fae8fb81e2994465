"""A node in the style of TurtleBot 3's own examples: relative names, sensor QoS, Twist."""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

STOP_DISTANCE = 0.6  # metres
SPEED = 0.22  # metres per second, the Burger's most


class WallStopper(Node):
    def __init__(self):
        super().__init__("wall_stopper")
        self.cmd_vel_pub = self.create_publisher(Twist, "cmd_vel", 10)
        self.scan_sub = self.create_subscription(
            LaserScan, "scan", self.scan_callback, qos_profile_sensor_data
        )

    def scan_callback(self, msg):
        ahead = [*msg.ranges[:20], *msg.ranges[-20:]]  # an LDS-01 begins straight ahead
        seen = [r for r in ahead if not math.isnan(r) and r > 0.0]  # 0.0: nothing came back
        twist = Twist()
        twist.linear.x = SPEED if min(seen, default=math.inf) > STOP_DISTANCE else 0.0
        self.cmd_vel_pub.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = WallStopper()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
