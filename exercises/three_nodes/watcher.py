"""Watcher: perception. How far away is the nearest thing ahead?

Subscribes  scan      sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   distance  std_msgs/msg/Float64       the smallest usable one ahead [m], for each scan
"""

import math

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64


def front_distance(scan: LaserScan) -> float | None:
    """Return the smallest usable distance within ±90° of ahead [m]; ``None``: blind."""
    usable = []
    for index, reading in enumerate(scan.ranges):
        angle = math.remainder(scan.angle_min + index * scan.angle_increment, math.tau)
        if abs(angle) > math.pi / 2:
            continue
        if reading == -math.inf:
            usable.append(0.0)
        elif reading == math.inf or scan.range_min <= reading <= scan.range_max:
            usable.append(reading)
    return min(usable, default=None)


class Watcher(Node):
    """Publishes one number for each scan; of a scan in which nothing is usable, none."""

    def __init__(self) -> None:
        super().__init__("watcher")
        self.publisher = self.create_publisher(Float64, "distance", 10)
        self.create_subscription(LaserScan, "scan", self.scan_callback, qos_profile_sensor_data)

    def scan_callback(self, scan: LaserScan) -> None:
        """Perceive, and tell."""
        # TODO(task 4): publish the front_distance of the scan, if there is one.


def main(args: list[str] | None = None) -> None:
    """Watch until Ctrl-C."""
    try:
        rclpy.init(args=args)
        rclpy.spin(Watcher())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
