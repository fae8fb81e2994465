"""As little code as the contract allows.

field: all
"""

import math

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool
from tf2_ros import Buffer, TransformException, TransformListener


class Supervisor(Node):
    def __init__(self):
        super().__init__("safety_supervisor")
        self.e_stop = False
        self.raw = None
        self.raw_time = None
        self.distance = None
        self.scan_time = None
        self.last = 0.0
        self.reported = None
        self.report_time = None
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Twist, "/cmd_vel_raw", self.raw_callback, 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.create_subscription(Bool, "/e_stop", self.e_stop_callback, 10)
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.create_timer(0.05, self.tick)

    def now(self):
        return self.get_clock().now().nanoseconds * 1e-9

    def raw_callback(self, twist):
        self.raw = twist
        self.raw_time = self.now()

    def scan_callback(self, scan):
        self.distance = self.perceive(scan)
        self.scan_time = self.now()

    def e_stop_callback(self, message):
        self.e_stop = message.data

    def front(self, frame):
        try:
            robot = self.buffer.lookup_transform(frame, "base_link", Time())
        except TransformException:
            return 0.0
        q = robot.transform.rotation
        return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))

    def perceive(self, scan):
        readings = []
        first = scan.angle_min - self.front(scan.header.frame_id)
        for i, r in enumerate(scan.ranges):
            angle = math.remainder(first + i * scan.angle_increment, math.tau)
            if abs(angle) > math.pi / 2:
                continue
            if r == -math.inf:
                readings.append(0.0)
            elif r == math.inf or scan.range_min <= r <= scan.range_max:
                readings.append(r)
        return min(readings, default=None)

    def is_finite(self, twist):
        parts = (twist.linear, twist.angular)
        return all(math.isfinite(getattr(part, axis)) for part in parts for axis in "xyz")

    def decide(self):
        now, raw = self.now(), self.raw
        if self.e_stop:
            return "e_stop", 0.0, 0.0
        if raw is not None and not self.is_finite(raw):
            return "bad_command", 0.0, 0.0
        if raw is None or now - self.raw_time > 0.5:
            return "stale_command", 0.0, 0.0
        if self.distance is None or now - self.scan_time > 0.5:
            return "stale_scan", 0.0, 0.0
        turn = max(-1.9, min(1.9, raw.angular.z))
        if self.distance < 0.5 and raw.linear.x > 0.0:
            return "obstacle", 0.0, turn
        speed = max(-0.5, min(0.5, raw.linear.x))
        speed = min(speed, max(0.0, self.last) + 0.045)
        changed = speed != raw.linear.x or turn != raw.angular.z
        return "limited" if changed else "ok", speed, turn

    def tick(self):
        reason, speed, turn = self.decide()
        twist = Twist()
        twist.linear.x = speed
        twist.angular.z = turn
        self.publisher.publish(twist)
        self.last = speed
        if reason != self.reported or self.now() - self.report_time > 0.9:
            self.report(reason)

    def report(self, reason):
        status = DiagnosticStatus()
        status.level = self.level(reason)
        status.name = "safety_supervisor"
        status.message = reason
        self.diagnostics.publish(DiagnosticArray(status=[status]))
        self.reported = reason
        self.report_time = self.now()

    def level(self, reason):
        if reason == "ok":
            return DiagnosticStatus.OK
        if reason in ("obstacle", "limited"):
            return DiagnosticStatus.WARN
        return DiagnosticStatus.ERROR


def main(args=None):
    rclpy.init(args=args)
    node = Supervisor()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
