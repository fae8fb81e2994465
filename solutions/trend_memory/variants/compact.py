"""As little code as the contract allows.

field: all
"""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64


class Agent(Node):
    def __init__(self):
        super().__init__("trend_agent")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.closing_publisher = self.create_publisher(Float64, "/closing_speed", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.memory = []  # (stamp, distance)
        self.last_stamp = None
        self.get_logger().info("Trend agent started")

    def perceive(self, scan):
        readings = []
        for i, r in enumerate(scan.ranges):
            angle = math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)
            if abs(angle) > math.pi / 2:
                continue
            if r == -math.inf:
                readings.append(0.0)
            elif r == math.inf or scan.range_min <= r <= scan.range_max:
                readings.append(r)
        return min(readings, default=None)

    def closing_speed(self):
        times = [t - self.memory[0][0] for t, _ in self.memory]
        distances = [d for _, d in self.memory]
        n = len(times)
        mean_t, mean_d = sum(times) / n, sum(distances) / n
        above = sum((t - mean_t) * (d - mean_d) for t, d in zip(times, distances))
        below = sum((t - mean_t) ** 2 for t in times)
        return -above / below if below else 0.0

    def remember(self, stamp, distance):
        if self.last_stamp is not None:
            if stamp < self.last_stamp or stamp - self.last_stamp > 1.0:
                self.memory.clear()
        self.last_stamp = stamp
        if distance is None or distance == math.inf:
            return None
        self.memory.append((stamp, distance))
        self.memory = self.memory[-10:]
        if len(self.memory) < 10:
            return None
        closing = self.closing_speed()
        self.closing_publisher.publish(Float64(data=closing))
        return closing

    def decide(self, distance, closing):
        if distance is None or distance < 0.5:
            return 0.0
        if closing is not None and closing > 0.0 and distance / closing < 2.0:
            return 0.0
        return 0.3

    def scan_callback(self, scan):
        stamp = scan.header.stamp.sec + scan.header.stamp.nanosec * 1e-9
        distance = self.perceive(scan)
        closing = self.remember(stamp, distance)
        twist = Twist()
        twist.linear.x = self.decide(distance, closing)
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = Agent()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
