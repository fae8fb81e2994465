"""Style: the rules are a table of functions, tried one after another; numpy looks at the scan.

field: all
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

STALE = Duration(seconds=0.5)
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
Answer = tuple[float, float] | None  # linear.x, angular.z; None: the rule does not match


class Facts(NamedTuple):
    e_stop: bool
    asked: np.ndarray | None  # the six fields, if they are fresh or never go stale
    fresh_command: bool
    distance: float  # [m], NaN: not known
    last: float  # [m/s]


def zero_if(condition: Callable[[Facts], bool]) -> Callable[[Facts], Answer]:
    return lambda facts: (0.0, 0.0) if condition(facts) else None


def turned(facts: Facts) -> float:
    return float(np.clip(facts.asked[5], -1.9, 1.9))


def obstacle(facts: Facts) -> Answer:
    return (0.0, turned(facts)) if facts.distance < 0.5 and facts.asked[0] > 0.0 else None


def limited(facts: Facts) -> Answer:
    speed = float(np.clip(facts.asked[0], -0.5, 0.5))
    speed = min(speed, max(facts.last, 0.0) + 0.9 * 0.05)
    answer = (speed, turned(facts))
    return None if answer == (facts.asked[0], facts.asked[5]) else answer


def ok(facts: Facts) -> Answer:
    return float(facts.asked[0]), float(facts.asked[5])


RULES = (
    ("e_stop", ERROR, zero_if(lambda f: f.e_stop)),
    (
        "bad_command",
        ERROR,
        zero_if(lambda f: f.asked is not None and not np.isfinite(f.asked).all()),
    ),
    ("stale_command", ERROR, zero_if(lambda f: not f.fresh_command)),
    ("stale_scan", ERROR, zero_if(lambda f: np.isnan(f.distance))),
    ("obstacle", WARN, obstacle),
    ("limited", WARN, limited),
    ("ok", OK, ok),
)


class SafetySupervisor(Node):
    def __init__(self) -> None:
        super().__init__("safety_supervisor")
        self.pressed, self.asked, self.distance, self.last = False, None, np.nan, 0.0
        never = self.get_clock().now() - Duration(seconds=1000)
        self.command_at = self.scan_at = self.report_at = never
        self.said = ""
        self.motors = self.create_publisher(Twist, "cmd_vel", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "diagnostics", 10)
        self.create_subscription(Twist, "cmd_vel_raw", self.on_command, 10)
        self.create_subscription(LaserScan, "scan", self.on_scan, qos_profile_sensor_data)
        self.create_subscription(Bool, "e_stop", self.on_e_stop, 10)
        self.create_timer(0.05, self.on_tick)

    def on_command(self, twist: Twist) -> None:
        linear, angular = twist.linear, twist.angular
        self.asked = np.array([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
        self.command_at = self.get_clock().now()

    def on_scan(self, scan: LaserScan) -> None:
        ranges = np.asarray(scan.ranges, dtype=np.float64)  # (n_beams,) [m]
        angles = scan.angle_min + scan.angle_increment * np.arange(ranges.size)  # [rad]
        meant = (ranges >= scan.range_min) & (ranges <= scan.range_max) | np.isinf(ranges)
        usable = ranges[(np.cos(angles) >= -1e-6) & meant]
        self.distance = max(0.0, usable.min()) if usable.size else np.nan
        self.scan_at = self.get_clock().now()

    def on_e_stop(self, message: Bool) -> None:
        self.pressed = message.data
        if self.pressed:  # at once, and again at every tick
            self.motors.publish(Twist())
            self.last = 0.0

    def on_tick(self) -> None:
        now = self.get_clock().now()
        facts = Facts(
            self.pressed,
            self.asked,
            now - self.command_at <= STALE,
            self.distance if now - self.scan_at <= STALE else np.nan,
            self.last,
        )
        for reason, level, rule in RULES:
            answer = rule(facts)
            if answer is not None:
                break
        twist = Twist()
        twist.linear.x, twist.angular.z = answer
        self.motors.publish(twist)
        self.last = twist.linear.x
        if reason != self.said or now - self.report_at >= Duration(seconds=1.0):
            self.said, self.report_at = reason, now
            self.report(reason, level, answer)

    def report(self, reason: str, level: bytes, answer: tuple[float, float]) -> None:
        values = [KeyValue(key="linear.x", value=f"{answer[0]:.3f}")]
        status = DiagnosticStatus(
            level=level, name="supervisor", message=f"{reason} (rule)", values=values
        )
        self.diagnostics.publish(DiagnosticArray(status=[status]))


def main(args=None) -> None:
    rclpy.init(args=args)
    node = SafetySupervisor()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
