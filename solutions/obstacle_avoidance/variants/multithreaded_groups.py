"""Style: callback groups and a MultiThreadedExecutor, with a timer that reports once a second.

field: all
"""

import math
from threading import Lock

import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from tf2_ros import Buffer, TransformListener


class ObstacleAvoidanceAgent(Node):
    def __init__(self) -> None:
        super().__init__("obstacle_avoidance_agent")
        self.lock = Lock()
        self.decisions = 0
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        # Scans one after another, the report beside them.
        self.create_subscription(
            LaserScan,
            "/scan",
            self.scan_callback,
            qos_profile_sensor_data,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )
        self.create_timer(
            1.0, self.report_callback, callback_group=MutuallyExclusiveCallbackGroup()
        )
        self.frames = Buffer()
        self.frames_listener = TransformListener(self.frames, self)
        self.get_logger().info("multi-threaded agent started")

    def scan_callback(self, scan: LaserScan) -> None:
        forward = math.pi - self.lidar_yaw(scan.header.frame_id)
        nearest = None
        for i, reading in enumerate(scan.ranges):
            turned = (scan.angle_min + i * scan.angle_increment + forward) % (2 * math.pi)
            if not math.pi / 2 <= turned <= 3 * math.pi / 2:  # here ahead is π
                continue
            if math.isinf(reading) or scan.range_min <= reading <= scan.range_max:
                nearest = reading if nearest is None else min(nearest, reading)

        twist = Twist()
        if nearest is not None and nearest >= 0.5:
            twist.linear.x = 0.5 if nearest >= 1.0 else 0.15
        self.publisher.publish(twist)
        self.get_logger().info(f"distance {nearest} m, velocity {twist.linear.x:.2f} m/s")
        with self.lock:
            self.decisions += 1

    def lidar_yaw(self, frame: str) -> float:
        """Angle [rad] of the robot's front in the lidar's frame; 0 if it is not known."""
        if not self.frames.can_transform(frame, "base_link", Time()):
            return 0.0
        rotation = self.frames.lookup_transform(frame, "base_link", Time()).transform.rotation
        return 2.0 * math.atan2(rotation.z, rotation.w)

    def report_callback(self) -> None:
        with self.lock:
            self.get_logger().info(f"{self.decisions} decisions so far")


def main(args=None) -> None:
    rclpy.init(args=args)
    node = ObstacleAvoidanceAgent()
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
