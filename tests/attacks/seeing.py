"""The right speeds and a plain right node, for honest submissions whose oddity lies elsewhere."""

import math

from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def right_speed(scan) -> float:
    """Return the speed [m/s] for a scan."""
    seen = []
    for index, reading in enumerate(scan.ranges):
        angle = math.remainder(scan.angle_min + index * scan.angle_increment, math.tau)
        if abs(angle) > math.pi / 2:
            continue
        if reading == -math.inf:
            seen.append(0.0)
        elif reading == math.inf or scan.range_min <= reading <= scan.range_max:
            seen.append(reading)
    nearest = min(seen, default=0.0)
    return 0.0 if nearest < 0.5 else 0.15 if nearest < 1.0 else 0.5


class Agent(Node):
    """Answers each scan; an odd one may change `decide`."""

    def __init__(self, **options):
        super().__init__("obstacle_avoidance_agent", **options)
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = self.decide(scan)
        self.cmd_vel.publish(twist)

    def decide(self, scan):
        """Return a speed [m/s]."""
        return right_speed(scan)
