"""Style: numpy, two ring buffers and np.polyfit.

field: all
"""

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

SIZE = 10


def front_distance(scan: LaserScan) -> float:
    """Smallest usable distance ahead [m]; NaN when there is none."""
    ranges = np.asarray(scan.ranges, dtype=np.float64)  # (n_beams,) [m]
    angles = scan.angle_min + scan.angle_increment * np.arange(ranges.size)  # (n_beams,) [rad]
    ahead = np.cos(angles) >= -1e-6
    within_limits = (ranges >= scan.range_min) & (ranges <= scan.range_max)
    usable = ranges[ahead & (within_limits | np.isinf(ranges))]
    return max(0.0, float(usable.min())) if usable.size else float("nan")


class TrendAgent(Node):
    def __init__(self) -> None:
        super().__init__("trend_agent")
        self.stamps = np.zeros(SIZE, dtype=np.int64)  # [ns]
        self.distances = np.zeros(SIZE)  # [m]
        self.count = 0
        self.newest = None
        self.motors = self.create_publisher(Twist, "cmd_vel", 10)
        self.closing = self.create_publisher(Float64, "closing_speed", 10)
        self.create_subscription(LaserScan, "scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan: LaserScan) -> None:
        stamp = Time.from_msg(scan.header.stamp).nanoseconds
        if self.newest is not None and not 0 <= stamp - self.newest <= 1_000_000_000:
            self.count = 0
        self.newest = stamp

        distance = front_distance(scan)
        trend = self.trend(stamp, distance) if np.isfinite(distance) else 0.0
        hurry = trend > 0.0 and distance < 2.0 * trend
        stop = np.isnan(distance) or distance < 0.5 or hurry
        command = Twist()
        command.linear.x = 0.0 if stop else 0.3
        self.motors.publish(command)

    def trend(self, stamp: int, distance: float) -> float:
        """Remember a reading; return the closing speed [m/s], 0 while it is not known."""
        slot = self.count % SIZE
        self.stamps[slot], self.distances[slot] = stamp, distance
        self.count += 1
        if self.count < SIZE:
            return 0.0
        seconds = (self.stamps - stamp) / 1e9  # the order does not matter to a line
        closing = -float(np.polyfit(seconds, self.distances, 1)[0]) if seconds.any() else 0.0
        self.closing.publish(Float64(data=closing))
        return closing


def main(args=None) -> None:
    rclpy.init(args=args)
    node = TrendAgent()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
