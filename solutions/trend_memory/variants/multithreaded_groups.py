"""Style: callback groups and a MultiThreadedExecutor; a lock around the memory, a timer reports.

field: all
"""

import math
from collections import deque
from threading import Lock

import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64


class Memory:
    """The last ten readings, safe to share between threads."""

    def __init__(self) -> None:
        self.lock = Lock()
        self.readings: deque[tuple[float, float]] = deque(maxlen=10)
        self.newest = -math.inf  # [s]

    def tick(self, stamp: float) -> None:
        """Take note of a scan's stamp [s]: after a jump everything is forgotten."""
        with self.lock:
            jumped = stamp < self.newest or stamp > self.newest + 1.0
            self.newest = stamp
            if jumped:
                self.readings.clear()

    def add(self, stamp: float, distance: float) -> float | None:
        """Remember a reading; return the closing speed [m/s], if it is known."""
        with self.lock:
            self.readings.append((stamp, distance))
            if len(self.readings) < 10:
                return None
            middle = sum(t for t, _ in self.readings) / 10
            weights = [t - middle for t, _ in self.readings]
            rise = sum(w * d for w, (_, d) in zip(weights, self.readings))
            spread = sum(w * w for w in weights)
            return -rise / spread if spread else 0.0


class TrendAgent(Node):
    def __init__(self) -> None:
        super().__init__("trend_agent")
        self.memory = Memory()
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.closing_publisher = self.create_publisher(Float64, "/closing_speed", 10)
        self.create_subscription(
            LaserScan,
            "/scan",
            self.scan_callback,
            qos_profile_sensor_data,
            callback_group=MutuallyExclusiveCallbackGroup(),  # scans one after another
        )
        self.create_timer(
            1.0, self.report_callback, callback_group=MutuallyExclusiveCallbackGroup()
        )

    def scan_callback(self, scan: LaserScan) -> None:
        nearest = None
        for i, reading in enumerate(scan.ranges):
            turned = (scan.angle_min + i * scan.angle_increment + math.pi) % (2 * math.pi)
            if not math.pi / 2 <= turned <= 3 * math.pi / 2:  # here ahead is π
                continue
            if math.isinf(reading) or scan.range_min <= reading <= scan.range_max:
                nearest = reading if nearest is None else min(nearest, reading)
        if nearest == -math.inf:
            nearest = 0.0

        stamp = scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9
        self.memory.tick(stamp)
        closing = None
        if nearest is not None and nearest < math.inf:
            closing = self.memory.add(stamp, nearest)
        if closing is not None:
            self.closing_publisher.publish(Float64(data=closing))
        twist = Twist()
        if nearest is not None and nearest >= 0.5:
            time_left = nearest / closing if closing is not None and closing > 0.0 else math.inf
            twist.linear.x = 0.3 if time_left >= 2.0 else 0.0
        self.publisher.publish(twist)

    def report_callback(self) -> None:
        with self.memory.lock:
            self.get_logger().info(f"{len(self.memory.readings)} readings remembered")


def main(args=None) -> None:
    rclpy.init(args=args)
    node = TrendAgent()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
