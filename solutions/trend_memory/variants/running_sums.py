"""Style: no fit over the memory at all: exact running sums in whole nanoseconds and micrometres.

field: all
"""

import math
from collections import deque
from fractions import Fraction

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

SCAN_QOS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=3, reliability=ReliabilityPolicy.BEST_EFFORT
)


class SlidingLine:
    """The line through the last n points; a point comes and goes in constant time."""

    def __init__(self, n: int) -> None:
        self.n = n
        self.clear()

    def clear(self) -> None:
        self.points: deque[tuple[int, int]] = deque()
        self.x = self.y = self.xx = self.xy = 0

    def add(self, x: int, y: int) -> None:
        self.points.append((x, y))
        self._count(x, y, +1)
        if len(self.points) > self.n:
            self._count(*self.points.popleft(), -1)

    def _count(self, x: int, y: int, sign: int) -> None:
        self.x += sign * x
        self.y += sign * y
        self.xx += sign * x * x
        self.xy += sign * x * y

    def slope(self) -> Fraction | None:
        """Whole numbers of any size: nothing is rounded before the division."""
        spread = self.n * self.xx - self.x**2
        if len(self.points) < self.n or not spread:
            return None
        return Fraction(self.n * self.xy - self.x * self.y, spread)


class TrendAgent(Node):
    def __init__(self) -> None:
        super().__init__("trend_agent")
        self.line = SlidingLine(10)
        self.stamp: int | None = None  # [ns]
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", QoSProfile(depth=1))
        self.closing_speed = self.create_publisher(Float64, "/closing_speed", QoSProfile(depth=1))
        self.create_subscription(LaserScan, "/scan", self.scan_callback, SCAN_QOS)

    def scan_callback(self, scan: LaserScan) -> None:
        stamp = scan.header.stamp.sec * 10**9 + scan.header.stamp.nanosec
        gap = 0 if self.stamp is None else stamp - self.stamp
        self.stamp = stamp
        if gap < 0 or gap > 10**9:
            self.line.clear()

        ahead = [
            self.meaning(scan, reading)
            for i, reading in enumerate(scan.ranges)
            if math.cos(scan.angle_min + i * scan.angle_increment) > -1e-6
        ]
        distance = min((d for d in ahead if d is not None), default=None)
        closing = None
        if distance is not None and math.isfinite(distance):
            self.line.add(stamp, round(distance * 1e6))
            slope = self.line.slope()  # [µm/ns]
            if slope is not None:
                closing = -float(slope) * 1e3  # [m/s]
                self.closing_speed.publish(Float64(data=closing))
        twist = Twist()
        twist.linear.x = self.speed(distance, closing)
        self.cmd_vel.publish(twist)

    @staticmethod
    def meaning(scan: LaserScan, reading: float) -> float | None:
        if math.isinf(reading):
            return reading if reading > 0 else 0.0
        return reading if scan.range_min <= reading <= scan.range_max else None

    @staticmethod
    def speed(distance: float | None, closing: float | None) -> float:
        match distance, closing:
            case None, _:
                return 0.0
            case d, _ if d < 0.5:
                return 0.0
            case d, float(c) if c > 0.0 and d / c < 2.0:
                return 0.0
        return 0.3


def main(args=None) -> None:
    rclpy.init(args=args)
    executor = SingleThreadedExecutor()
    node = TrendAgent()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        node.cmd_vel.publish(Twist())  # leave the robot standing
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
