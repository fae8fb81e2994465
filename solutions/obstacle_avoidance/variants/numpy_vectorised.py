"""Style: numpy, the whole scan at once, no Python loop.

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
from tf2_ros import Buffer, TransformException, TransformListener


def front_distance(scan: LaserScan) -> float:
    """Smallest usable distance ahead [m]; NaN when there is none."""
    ranges = np.asarray(scan.ranges, dtype=np.float64)  # (n_beams,) [m]
    angles = scan.angle_min + scan.angle_increment * np.arange(ranges.size)  # (n_beams,) [rad]
    ahead = np.cos(angles) >= -1e-6  # cos is not negative within ±90°, however beams are counted
    within_limits = (ranges >= scan.range_min) & (ranges <= scan.range_max)
    usable = ranges[ahead & (within_limits | np.isinf(ranges))]
    if usable.size == 0:
        return np.nan
    return max(0.0, float(usable.min()))  # -inf: closer than the sensor can measure


class ObstacleAvoidanceAgent(Node):
    def __init__(self) -> None:
        super().__init__("obstacle_avoidance_agent")
        self.publisher = self.create_publisher(Twist, "cmd_vel", 10)
        self.create_subscription(LaserScan, "scan", self.on_scan, qos_profile_sensor_data)
        self.tree = Buffer()
        self.tree_listener = TransformListener(self.tree, self)
        self.get_logger().info("numpy agent ready")

    def mounting(self, frame: str) -> float:
        """How far the lidar is turned on the robot [rad]; 0 while nobody has said."""
        try:
            turn = self.tree.lookup_transform("base_link", frame, Time()).transform.rotation
        except TransformException:
            return 0.0
        return 2.0 * float(np.arctan2(turn.z, turn.w))

    def on_scan(self, scan: LaserScan) -> None:
        scan.angle_min += self.mounting(scan.header.frame_id)  # from now on 0 is the robot's front
        distance = front_distance(scan)
        # Two thresholds, three speeds. NaN sorts behind everything, so it gets a zone of its own.
        zone = int(np.searchsorted([0.5, 1.0, np.inf], distance, side="right"))
        speed = 0.0 if np.isnan(distance) else [0.0, 0.15, 0.5, 0.5][zone]
        command = Twist()
        command.linear.x = speed
        self.publisher.publish(command)
        self.get_logger().info(f"distance {distance:.2f} m -> velocity {speed:.2f} m/s")


def main(args=None) -> None:
    rclpy.init(args=args)
    node = ObstacleAvoidanceAgent()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
