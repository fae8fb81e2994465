"""Style: a queue and a worker thread; a generator keeps the memory between two scans.

field: all
"""

import math
import queue
import threading

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64


def trends():
    """Take (stamp [ns], distance [m]) pairs; give the closing speed [m/s] or None for each."""
    readings, newest, closing = [], None, None
    while True:
        stamp, distance = yield closing
        if newest is not None and (stamp < newest or stamp > newest + 1_000_000_000):
            readings = []
        newest, closing = stamp, None
        if math.isfinite(distance):
            readings = [*readings, (stamp, distance)][-10:]
            if len(readings) == 10:
                closing = -slope([((t - stamp) * 1e-9, d) for t, d in readings])


def slope(points):
    """Least-squares slope: the mean of all pairs' slopes, each with the square of its width."""
    rise = run = 0.0
    for i, (t0, d0) in enumerate(points):
        for t1, d1 in points[i + 1 :]:
            rise += (t1 - t0) * (d1 - d0)
            run += (t1 - t0) ** 2
    return rise / run if run else 0.0


class TrendAgent(Node):
    def __init__(self) -> None:
        super().__init__("trend_agent")
        self.scans: queue.Queue[LaserScan | None] = queue.Queue()
        self.motors = self.create_publisher(Twist, "/cmd_vel", 10)
        self.closing = self.create_publisher(Float64, "/closing_speed", 10)
        self.create_subscription(LaserScan, "/scan", self.scans.put, qos_profile_sensor_data)
        threading.Thread(target=self.work, daemon=True).start()

    def work(self) -> None:
        trend = trends()
        next(trend)
        while (scan := self.scans.get()) is not None:
            distance = self.distance_ahead(scan)
            stamp = scan.header.stamp.sec * 1_000_000_000 + scan.header.stamp.nanosec
            closing = trend.send((stamp, distance))
            twist = Twist()
            if distance >= 0.5:  # false for NaN
                danger = closing is not None and distance < 2.0 * closing
                twist.linear.x = 0.0 if danger else 0.3
            self.motors.publish(twist)
            if closing is not None:
                self.closing.publish(Float64(data=closing))

    def distance_ahead(self, scan: LaserScan) -> float:
        """Smallest usable distance ahead [m]; NaN when there is none."""
        best = math.nan
        for i, reading in enumerate(scan.ranges):
            if math.cos(scan.angle_min + i * scan.angle_increment) < -1e-6:
                continue
            if reading == -math.inf:
                return 0.0
            if reading == math.inf or scan.range_min <= reading <= scan.range_max:
                best = reading if math.isnan(best) else min(best, reading)
        return best


def main(args=None) -> None:
    rclpy.init(args=args)
    node = TrendAgent()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.scans.put(None)
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
