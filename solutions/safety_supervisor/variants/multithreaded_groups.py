"""Style: a MultiThreadedExecutor with one callback group each for inputs, control and reports.

field: all
"""

import math
from dataclasses import dataclass, replace
from threading import Lock

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool
from tf2_ros import Buffer, TransformListener


@dataclass(frozen=True)
class Inputs:
    """Never changed, only replaced: the control loop sees one moment, not half of two."""

    e_stop: bool = False
    asked: tuple[float, float] = (0.0, 0.0)  # [m/s], [rad/s]
    finite: bool = True
    asked_at: float = -math.inf  # [s]
    distance: float | None = None  # [m]
    scan_at: float = -math.inf  # [s]


class SafetySupervisor(Node):
    def __init__(self) -> None:
        super().__init__("safety_supervisor")
        self.lock, self.inputs = Lock(), Inputs()
        self.speed, self.reason, self.reported_at = 0.0, "", -math.inf
        inputs, control = ReentrantCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(
            Twist, "/cmd_vel_raw", self.command_callback, 10, callback_group=inputs
        )
        self.create_subscription(
            LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data, callback_group=inputs
        )
        self.create_subscription(Bool, "/e_stop", self.e_stop_callback, 10, callback_group=inputs)
        self.create_timer(0.05, self.control_callback, callback_group=control)
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)

    def seconds(self) -> float:
        return self.get_clock().now().nanoseconds * 1e-9

    def learn(self, **changes) -> None:
        with self.lock:
            self.inputs = replace(self.inputs, **changes)

    def command_callback(self, twist: Twist) -> None:
        fields = [getattr(part, axis) for part in (twist.linear, twist.angular) for axis in "xyz"]
        self.learn(
            asked=(fields[0], fields[5]),
            finite=math.isfinite(sum(abs(field) for field in fields)),
            asked_at=self.seconds(),
        )

    def e_stop_callback(self, message: Bool) -> None:
        self.learn(e_stop=message.data)

    def mounting(self, frame: str) -> float:
        if not self.buffer.can_transform("base_link", frame, Time()):
            return 0.0
        q = self.buffer.lookup_transform("base_link", frame, Time()).transform.rotation
        return 2 * math.atan2(q.z, q.w)

    def scan_callback(self, scan: LaserScan) -> None:
        nearest = None
        first = scan.angle_min + self.mounting(scan.header.frame_id) + math.pi  # here ahead is π
        for i, reading in enumerate(scan.ranges):
            if not math.pi / 2 <= (first + i * scan.angle_increment) % math.tau <= 1.5 * math.pi:
                continue
            if math.isinf(reading) or scan.range_min <= reading <= scan.range_max:
                nearest = reading if nearest is None else min(nearest, reading)
        self.learn(distance=nearest, scan_at=self.seconds())

    def control_callback(self) -> None:
        with self.lock:
            inputs = self.inputs
        now = self.seconds()
        reason, level, speed, turn_rate = self.judge(inputs, now)
        twist = Twist()
        twist.linear.x, twist.angular.z = speed, turn_rate
        self.cmd_vel.publish(twist)
        self.speed = speed
        if reason != self.reason or now - self.reported_at > 0.92:
            self.reason, self.reported_at = reason, now
            status = DiagnosticStatus(level=level, name="safety supervisor", message=reason)
            self.diagnostics.publish(DiagnosticArray(status=[status]))

    def judge(self, inputs: Inputs, now: float) -> tuple[str, bytes, float, float]:
        stop = (DiagnosticStatus.ERROR, 0.0, 0.0)
        if inputs.e_stop:
            return ("e_stop", *stop)
        if not inputs.finite:
            return ("bad_command", *stop)
        if now - inputs.asked_at > 0.5:
            return ("stale_command", *stop)
        if inputs.distance is None or now - inputs.scan_at > 0.5:
            return ("stale_scan", *stop)
        speed, turn_rate = inputs.asked
        turn_rate = max(-1.9, min(turn_rate, 1.9))
        if inputs.distance < 0.5 and speed > 0.0:
            return "obstacle", DiagnosticStatus.WARN, 0.0, turn_rate
        speed = max(-0.5, min(speed, 0.5, max(self.speed, 0.0) + 0.045))
        if (speed, turn_rate) != inputs.asked:
            return "limited", DiagnosticStatus.WARN, speed, turn_rate
        return "ok", DiagnosticStatus.OK, speed, turn_rate


def main(args=None) -> None:
    rclpy.init(args=args)
    node = SafetySupervisor()
    executor = MultiThreadedExecutor(num_threads=3)
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
