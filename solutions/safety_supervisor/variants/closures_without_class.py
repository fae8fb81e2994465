"""Style: functions and closures, no class; match decides, the state is a SimpleNamespace.

field: all
"""

import math
from types import SimpleNamespace

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, Vector3
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

WARNINGS = {"obstacle", "limited"}


def distance_ahead(scan):
    """Smallest usable distance ahead [m]; None when there is none."""
    best = None
    for i, r in enumerate(scan.ranges):
        if math.cos(scan.angle_min + i * scan.angle_increment) < -1e-6:
            continue
        if math.isinf(r) or scan.range_min <= r <= scan.range_max:
            r = max(r, 0.0)
            best = r if best is None else min(best, r)
    return best


def numbers(twist):
    for vector in (twist.linear, twist.angular):
        yield from (vector.x, vector.y, vector.z)


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("safety_supervisor")
    clock = node.get_clock()
    cmd_vel = node.create_publisher(Twist, "/cmd_vel", 1)
    diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 5)
    state = SimpleNamespace(
        stop=False, raw=None, raw_at=-math.inf, scan=None, scan_at=-math.inf, v=0.0
    )
    report = SimpleNamespace(reason=None, at=-math.inf)

    def seconds():
        return clock.now().nanoseconds / 1e9

    def on_raw(twist):
        state.raw, state.raw_at = twist, seconds()

    def on_scan(scan):
        state.scan, state.scan_at = distance_ahead(scan), seconds()

    def on_stop(message):
        state.stop = message.data

    def why_stop(now):
        if state.stop:
            return "e_stop"
        if state.raw is not None and not all(map(math.isfinite, numbers(state.raw))):
            return "bad_command"
        if now - state.raw_at > 0.5:
            return "stale_command"
        if now - state.scan_at > 0.5 or state.scan is None:
            return "stale_scan"
        return None

    def on_tick():
        now = seconds()
        speed = turn = 0.0
        reason = why_stop(now)
        if reason is None:
            asked = state.raw
            turn = math.copysign(min(abs(asked.angular.z), 1.9), asked.angular.z)
            most = min(0.5, max(0.0, state.v) + 0.045)
            match state.scan < 0.5, asked.linear.x:
                case True, v if v > 0.0:
                    reason = "obstacle"
                case _, v:
                    speed = min(max(v, -0.5), most)
                    same = (speed, turn) == (v, asked.angular.z)
                    reason = "ok" if same else "limited"
        cmd_vel.publish(Twist(linear=Vector3(x=speed), angular=Vector3(z=turn)))
        state.v = speed
        if reason == report.reason and now < report.at + 0.99:
            return
        report.reason, report.at = reason, now
        level = DiagnosticStatus.ERROR
        if reason == "ok":
            level = DiagnosticStatus.OK
        elif reason in WARNINGS:
            level = DiagnosticStatus.WARN
        diagnostics.publish(
            DiagnosticArray(status=[DiagnosticStatus(level=level, name="s", message=reason)])
        )

    node.create_subscription(Twist, "/cmd_vel_raw", on_raw, 5)
    node.create_subscription(LaserScan, "/scan", on_scan, qos_profile_sensor_data)
    node.create_subscription(Bool, "/e_stop", on_stop, 5)
    node.create_timer(0.05, on_tick)
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
