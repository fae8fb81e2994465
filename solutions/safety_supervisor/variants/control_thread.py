"""Style: no timer: a thread runs the control loop on a steady beat, and spin() only listens.

field: all
"""

import math
import threading
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool
from tf2_ros import Buffer, TransformListener

PERIOD = 0.05  # [s]


def age(moment):
    """Seconds since a moment of time.monotonic(); inf for none."""
    return math.inf if moment is None else time.monotonic() - moment


class SafetySupervisor(Node):
    def __init__(self) -> None:
        super().__init__("safety_supervisor")
        self.pressed = False
        self.command = None, None  # Twist, when
        self.distance = None, None  # [m], when
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Twist, "/cmd_vel_raw", self.on_command, 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)
        self.create_subscription(Bool, "/e_stop", self.on_e_stop, 10)
        self.front = None  # [rad] in the scan's frame; None: not known
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)

    def on_e_stop(self, message: Bool) -> None:
        self.pressed = message.data

    def on_command(self, twist: Twist) -> None:
        self.command = twist, time.monotonic()  # one assignment: both or neither

    def on_scan(self, scan: LaserScan) -> None:
        best, frame = None, scan.header.frame_id
        if self.front is None and self.buffer.can_transform(frame, "base_link", Time()):
            q = self.buffer.lookup_transform(frame, "base_link", Time()).transform.rotation
            self.front = 2.0 * math.atan2(q.z, q.w)  # static: once is enough
        first = scan.angle_min - (self.front or 0.0)
        for i, reading in enumerate(scan.ranges):
            angle = math.remainder(first + i * scan.angle_increment, math.tau)
            usable = math.isinf(reading) or scan.range_min <= reading <= scan.range_max
            if usable and abs(angle) <= math.pi / 2 and (best is None or reading < best):
                best = reading
        self.distance = best, time.monotonic()

    def control_loop(self) -> None:
        last, said, said_at = 0.0, "", None
        beat = time.monotonic()
        while rclpy.ok():
            beat += PERIOD
            time.sleep(max(0.0, beat - time.monotonic()))
            reason, twist = self.decide(last)
            self.cmd_vel.publish(twist)
            last = twist.linear.x
            if reason != said or age(said_at) > 0.9:
                self.report(reason)
                said, said_at = reason, time.monotonic()

    def decide(self, last: float) -> tuple[str, Twist]:
        out = Twist()
        (asked, asked_at), (distance, seen_at) = self.command, self.distance
        if self.pressed:
            return "e_stop", out
        if asked is not None:
            both = asked.linear, asked.angular
            if not all(math.isfinite(n) for v in both for n in (v.x, v.y, v.z)):
                return "bad_command", out
        if age(asked_at) > 0.5:
            return "stale_command", out
        if age(seen_at) > 0.5 or distance is None:
            return "stale_scan", out
        out.angular.z = max(-1.9, min(1.9, asked.angular.z))
        if distance < 0.5 and asked.linear.x > 0.0:
            return "obstacle", out
        out.linear.x = max(-0.5, min(0.5, asked.linear.x, max(0.0, last) + 0.045))
        same = out.linear.x == asked.linear.x and out.angular.z == asked.angular.z
        return "ok" if same else "limited", out

    def report(self, reason: str) -> None:
        level = {"ok": b"\x00", "limited": b"\x01", "obstacle": b"\x01"}.get(reason, b"\x02")
        array = DiagnosticArray()
        array.header.stamp = self.get_clock().now().to_msg()
        array.status = [DiagnosticStatus(level=level, name="supervisor", message=reason)]
        self.diagnostics.publish(array)


def main(args=None) -> None:
    rclpy.init(args=args)
    node = SafetySupervisor()
    threading.Thread(target=node.control_loop, daemon=True).start()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
