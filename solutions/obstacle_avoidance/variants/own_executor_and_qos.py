"""Style: an executor of its own, hand-made QoS profiles, a sector computed from indices and kept.

field: all
"""

import math
from functools import lru_cache

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

SCAN_QOS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=ReliabilityPolicy.BEST_EFFORT,
    durability=DurabilityPolicy.VOLATILE,
)
STATIC_QOS = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
COMMAND_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)


@lru_cache(maxsize=4)
def indices_ahead(count: int, angle_min: float, increment: float) -> tuple[int, ...]:
    """Indices of the beams within ±90°; computed once for each kind of lidar."""
    return tuple(
        i
        for i in range(count)
        if abs(math.remainder(angle_min + i * increment, 2 * math.pi)) <= math.pi / 2
    )


class ObstacleAvoidanceAgent(Node):
    def __init__(self) -> None:
        super().__init__("obstacle_avoidance_agent")
        self.commands = self.create_publisher(Twist, "/cmd_vel", COMMAND_QOS)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, SCAN_QOS)
        self.mounted: dict[str, float] = {}  # yaw of each sensor on base_link [rad]
        self.create_subscription(TFMessage, "/tf_static", self.mounted_callback, STATIC_QOS)
        self.get_logger().info("agent started")

    def mounted_callback(self, message: TFMessage) -> None:
        for transform in message.transforms:
            if transform.header.frame_id == "base_link":
                turn = transform.transform.rotation
                self.mounted[transform.child_frame_id] = 2 * math.atan2(turn.z, turn.w)

    def scan_callback(self, scan: LaserScan) -> None:
        first = scan.angle_min + self.mounted.get(scan.header.frame_id, 0.0)
        ahead = indices_ahead(len(scan.ranges), first, scan.angle_increment)
        values = [self.meaning(scan, scan.ranges[i]) for i in ahead]
        known = [value for value in values if value is not None]
        distance = min(known) if known else 0.0
        speed = 0.0
        if distance >= 0.5:
            speed = 0.15
        if distance >= 1.0:
            speed = 0.5
        twist = Twist()
        twist.linear.x = speed
        self.commands.publish(twist)
        self.get_logger().info(f"distance {distance:.2f} m, velocity {speed:.2f} m/s")

    @staticmethod
    def meaning(scan: LaserScan, reading: float) -> float | None:
        """What one reading says about the distance [m]; None: nothing."""
        if math.isnan(reading):
            return None
        if math.isinf(reading):
            return reading if reading > 0 else 0.0
        return reading if scan.range_min <= reading <= scan.range_max else None


def main(args=None) -> None:
    rclpy.init(args=args)
    executor = SingleThreadedExecutor()
    node = ObstacleAvoidanceAgent()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        node.commands.publish(Twist())  # leave the robot standing
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
