"""Style: a queue and a worker thread; the callback hands over, the thread decides and publishes.

field: field_lds01, field_wide_lidar, field_best_effort, field_mirrored_world, field_speckle,
field_lost_scans
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


class ObstacleAvoidanceAgent(Node):
    def __init__(self) -> None:
        super().__init__("obstacle_avoidance_agent")
        self.scans: queue.Queue[LaserScan | None] = queue.Queue()
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scans.put, qos_profile_sensor_data)
        self.worker = threading.Thread(target=self.work, daemon=True)
        self.worker.start()
        self.get_logger().info("worker started")

    def work(self) -> None:
        while (scan := self.scans.get()) is not None:
            distance = self.distance_ahead(scan)
            twist = Twist()
            if distance >= 1.0:
                twist.linear.x = 0.5
            elif distance >= 0.5:
                twist.linear.x = 0.15
            self.publisher.publish(twist)
            self.get_logger().info(f"{distance:.2f} m -> {twist.linear.x:.2f} m/s")

    def distance_ahead(self, scan: LaserScan) -> float:
        """Smallest usable distance ahead [m]; -1 when there is none."""
        best = -1.0
        for i, reading in enumerate(scan.ranges):
            if math.cos(scan.angle_min + i * scan.angle_increment) < -1e-6:
                continue
            if reading == -math.inf:
                return 0.0
            if reading == math.inf or scan.range_min <= reading <= scan.range_max:
                best = reading if best < 0.0 else min(best, reading)
        return best


def main(args=None) -> None:
    rclpy.init(args=args)
    node = ObstacleAvoidanceAgent()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.scans.put(None)
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
