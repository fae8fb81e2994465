"""Style: functions and closures, no class; statistics.linear_regression draws the line.

field: all
"""

import math
from collections import deque
from statistics import linear_regression

import rclpy
from geometry_msgs.msg import Twist, Vector3
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64


def distances_ahead(scan):
    """Yield the distances [m] that count: ahead of the robot, and meaning something."""
    for i, r in enumerate(scan.ranges):
        theta = scan.angle_min + i * scan.angle_increment
        if abs(math.atan2(math.sin(theta), math.cos(theta))) > math.pi / 2:
            continue
        if math.isinf(r) or scan.range_min <= r <= scan.range_max:
            yield max(r, 0.0)


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("trend_agent")
    cmd_vel = node.create_publisher(Twist, "/cmd_vel", 1)
    closing_speed = node.create_publisher(Float64, "/closing_speed", 1)
    memory = deque(maxlen=10)
    before = None

    def trend():
        """Closing speed [m/s] over the memory."""
        start = memory[0][0]
        seconds = [(stamp - start) / 1e9 for stamp, _ in memory]
        if not any(seconds):
            return 0.0  # a clock that stands: no slope
        return -linear_regression(seconds, [distance for _, distance in memory]).slope

    def dangerous(distance, closing):
        return distance < 0.5 or (closing > 0 and distance / closing < 2.0)

    def on_scan(scan):
        nonlocal before
        now = scan.header.stamp.sec * 10**9 + scan.header.stamp.nanosec
        if before is not None and not before <= now <= before + 10**9:
            memory.clear()
        before = now
        distance = min(distances_ahead(scan), default=-1.0)
        closing = 0.0
        if 0.0 <= distance < math.inf:
            memory.append((now, distance))
            if len(memory) == memory.maxlen:
                closing = trend()
                closing_speed.publish(Float64(data=closing))
        speed = 0.0 if dangerous(distance, closing) else 0.3
        cmd_vel.publish(Twist(linear=Vector3(x=speed)))

    node.create_subscription(LaserScan, "/scan", on_scan, qos_profile_sensor_data)
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
