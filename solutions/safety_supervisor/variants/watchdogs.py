"""Style: no ages at all: watchdog timers that each message restarts say when something is stale.

field: all
"""

import math

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

SCAN_QOS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT
)
ONCE_QOS = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # what was sent once
LEVELS = dict.fromkeys(("obstacle", "limited"), DiagnosticStatus.WARN) | {"ok": DiagnosticStatus.OK}


class SafetySupervisor(Node):
    def __init__(self) -> None:
        super().__init__("safety_supervisor")
        self.e_stop = self.bad = False
        self.command: Twist | None = None  # None: stale
        self.distance: float | None = None  # None: stale or blind
        self.speed = 0.0
        self.reason, self.quiet_ticks = "", 0
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", QoSProfile(depth=1))
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Twist, "/cmd_vel_raw", self.command_callback, 1)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, SCAN_QOS)
        self.create_subscription(Bool, "/e_stop", self.e_stop_callback, 1)
        self.mountings: dict[str, float] = {}  # of frames on the robot [rad]
        self.create_subscription(TFMessage, "/tf_static", self.mounting_callback, ONCE_QOS)
        self.command_watchdog = self.create_timer(0.5, self.command_lost)
        self.scan_watchdog = self.create_timer(0.5, self.scan_lost)
        self.create_timer(0.05, self.control_callback)

    def command_lost(self) -> None:
        self.command = None

    def scan_lost(self) -> None:
        self.distance = None

    def mounting_callback(self, message: TFMessage) -> None:
        for each in message.transforms:
            if each.header.frame_id == "base_link":
                q = each.transform.rotation
                self.mountings[each.child_frame_id] = 2.0 * math.atan2(q.z, q.w)

    def command_callback(self, command: Twist) -> None:
        self.command_watchdog.reset()
        self.command = command
        self.bad = not all(
            math.isfinite(getattr(vector, axis))
            for vector in (command.linear, command.angular)
            for axis in "xyz"
        )

    def e_stop_callback(self, message: Bool) -> None:
        self.e_stop = message.data

    def scan_callback(self, scan: LaserScan) -> None:
        self.scan_watchdog.reset()
        usable = [math.inf if reading > 0 else 0.0 for reading in self.ahead(scan, math.isinf)]
        usable += self.ahead(scan, lambda r: scan.range_min <= r <= scan.range_max)
        self.distance = min(usable, default=None)

    def ahead(self, scan: LaserScan, counts) -> list[float]:
        first = scan.angle_min + self.mountings.get(scan.header.frame_id, 0.0)
        return [
            reading
            for i, reading in enumerate(scan.ranges)
            if counts(reading)
            and abs(math.remainder(first + i * scan.angle_increment, 2 * math.pi)) <= math.pi / 2
        ]

    def control_callback(self) -> None:
        reason, twist = self.judge()
        self.cmd_vel.publish(twist)
        self.speed = twist.linear.x
        self.quiet_ticks += 1
        if reason != self.reason or self.quiet_ticks == 20:
            self.reason, self.quiet_ticks = reason, 0
            status = DiagnosticStatus(name="safety", message=f"{reason} - {self.speed:+.2f} m/s")
            status.level = LEVELS.get(reason, DiagnosticStatus.ERROR)
            self.diagnostics.publish(DiagnosticArray(status=[status]))

    def judge(self) -> tuple[str, Twist]:
        twist = Twist()
        if self.e_stop:
            return "e_stop", twist
        if self.bad:
            return "bad_command", twist
        if self.command is None:
            return "stale_command", twist
        if self.distance is None:
            return "stale_scan", twist
        asked = self.command.linear.x, self.command.angular.z
        twist.angular.z = sorted((-1.9, asked[1], 1.9))[1]
        if asked[0] > 0.0 and self.distance < 0.5:
            return "obstacle", twist
        rise = max(0.0, self.speed) + 0.045
        twist.linear.x = min(rise, sorted((-0.5, asked[0], 0.5))[1])
        unchanged = (twist.linear.x, twist.angular.z) == asked
        return ("ok" if unchanged else "limited"), twist


def main(args=None) -> None:
    rclpy.init(args=args)
    executor = SingleThreadedExecutor()
    node = SafetySupervisor()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        node.cmd_vel.publish(Twist())  # leave the robot standing
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
