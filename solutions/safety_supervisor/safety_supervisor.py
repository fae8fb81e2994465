"""Safety supervisor: the last word between a model and the motors.

Subscribes  /cmd_vel_raw  geometry_msgs/msg/Twist                 what the model asks for
            /scan         sensor_msgs/msg/LaserScan               distances all around [m]
            /e_stop       std_msgs/msg/Bool                       true: the button is pressed
            /tf_static    tf2_msgs/msg/TFMessage                  how the lidar is mounted, if told
Publishes   /cmd_vel      geometry_msgs/msg/Twist                 what is safe, 20 times a second
            /diagnostics  diagnostic_msgs/msg/DiagnosticArray     the reason for it
"""

import math
import signal
from dataclasses import dataclass
from enum import StrEnum

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Quaternion, Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool
from tf2_ros import Buffer, TransformException, TransformListener

CONTROL_PERIOD = 0.05  # [s] 20 Hz
LONGEST_SILENCE = 0.5  # [s] what is older than this counts as not received
STOP_DISTANCE = 0.5  # [m] nearer than this: no way ahead
MAX_SPEED = 0.5  # [m/s]
MAX_TURN_RATE = 1.9  # [rad/s]
MAX_RISE = 0.045  # [m/s] that linear.x may rise in one tick: 0.9 m/s²
REPORT_PERIOD = 1.0  # [s] report at least this often
FRONT_HALF_ANGLE = math.pi / 2  # [rad] "ahead" is everything within ±90°
ROBOT_FRAME = "base_link"  # its x axis points ahead


class Reason(StrEnum):
    """Why the command is what it is; the first word of every diagnostic message."""

    E_STOP = "e_stop"
    BAD_COMMAND = "bad_command"
    STALE_COMMAND = "stale_command"
    STALE_SCAN = "stale_scan"
    OBSTACLE = "obstacle"
    LIMITED = "limited"
    OK = "ok"


LEVELS = {
    Reason.OK: DiagnosticStatus.OK,
    Reason.LIMITED: DiagnosticStatus.WARN,
    Reason.OBSTACLE: DiagnosticStatus.WARN,
}  # every other reason: DiagnosticStatus.ERROR


@dataclass(frozen=True)
class Situation:
    """All that a decision depends on."""

    e_stop: bool  # the button is pressed
    command: Twist | None  # the model's last command; None: there has been none
    command_age: float  # [s] since it arrived; inf: never
    distance: float | None  # [m] ahead in the newest scan; inf: free, None: blind
    scan_age: float  # [s] since that scan arrived; inf: never
    last_speed: float  # [m/s] linear.x of the last command that was published


@dataclass(frozen=True)
class Decision:
    """A command, and the reason for it."""

    reason: Reason
    speed: float = 0.0  # [m/s]
    turn_rate: float = 0.0  # [rad/s]


def front_distance(scan: LaserScan, front: float) -> float | None:
    """Return the smallest usable distance ahead [m], as in exercise 1; None: nothing is usable.

    `front` is the robot's front, as an angle of this scan [rad]: 0 where the lidar looks ahead.
    """
    usable = []
    for index, reading in enumerate(scan.ranges):
        angle = scan.angle_min + index * scan.angle_increment - front
        if abs(math.remainder(angle, math.tau)) > FRONT_HALF_ANGLE:
            continue
        if reading == -math.inf:
            usable.append(0.0)
        elif reading == math.inf or scan.range_min <= reading <= scan.range_max:
            usable.append(reading)
    return min(usable, default=None)


def yaw_of(q: Quaternion) -> float:
    """Return the angle by which a rotation turns the x axis [rad], seen from above."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def clamp(value: float, limit: float) -> float:
    """Return the value, or ±limit if it lies beyond."""
    return max(-limit, min(limit, value))


def is_finite(twist: Twist) -> bool:
    """Say whether all six fields are ordinary numbers."""
    linear, angular = twist.linear, twist.angular
    fields = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    return all(math.isfinite(value) for value in fields)


def decide(situation: Situation) -> Decision:
    """Return the command that is safe: the first rule that matches wins.

    At most MAX_RISE faster than the last command (than standstill, if that one drove backwards).
    Slowing down, stopping and driving backwards are never delayed.
    """
    ### BEGIN SOLUTION
    command = situation.command
    if situation.e_stop:
        return Decision(Reason.E_STOP)
    if command is not None and not is_finite(command):
        return Decision(Reason.BAD_COMMAND)
    if command is None or situation.command_age > LONGEST_SILENCE:
        return Decision(Reason.STALE_COMMAND)
    if situation.distance is None or situation.scan_age > LONGEST_SILENCE:
        return Decision(Reason.STALE_SCAN)

    asked_speed, asked_turn_rate = command.linear.x, command.angular.z
    turn_rate = clamp(asked_turn_rate, MAX_TURN_RATE)
    if situation.distance < STOP_DISTANCE and asked_speed > 0.0:
        return Decision(Reason.OBSTACLE, 0.0, turn_rate)
    fastest = max(0.0, situation.last_speed) + MAX_RISE
    speed = min(clamp(asked_speed, MAX_SPEED), fastest)
    as_asked = speed == asked_speed and turn_rate == asked_turn_rate
    return Decision(Reason.OK if as_asked else Reason.LIMITED, speed, turn_rate)
    ### SKELETON
    # # TODO(task 3): rules 1 to 4 stop the robot: e_stop, bad_command, stale_command, stale_scan.
    # # TODO(task 4): rules 5 to 7 let it drive: obstacle, limited (speed, turn rate, rise), ok.
    # return Decision(Reason.STALE_COMMAND)
    ### END SOLUTION


class SafetySupervisor(Node):
    """Passes on what a model asks for, as far as it is safe, and says why."""

    def __init__(self) -> None:
        super().__init__("safety_supervisor")
        self.e_stop = False
        self.command: Twist | None = None
        self.command_arrival: Time | None = None
        self.distance: float | None = None
        self.scan_arrival: Time | None = None
        self.last_speed = 0.0  # [m/s]
        self.reported: Reason | None = None  # the reason in the last report
        self.report_time: Time | None = None
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diagnostics_publisher = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.transforms = Buffer()
        self.transform_listener = TransformListener(self.transforms, self)
        ### BEGIN SOLUTION
        self.command_subscription = self.create_subscription(
            Twist, "/cmd_vel_raw", self.command_callback, 10
        )
        # "Sensor data" QoS takes scans from reliable and from best-effort publishers.
        self.scan_subscription = self.create_subscription(
            LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data
        )
        self.e_stop_subscription = self.create_subscription(
            Bool, "/e_stop", self.e_stop_callback, 10
        )
        self.control_timer = self.create_timer(CONTROL_PERIOD, self.control_callback)
        ### SKELETON
        # # TODO(task 1): subscribe to /cmd_vel_raw, /scan and /e_stop,
        # # and create a timer that calls self.control_callback every CONTROL_PERIOD seconds.
        ### END SOLUTION
        self.get_logger().info("Safety supervisor started")

    def command_callback(self, command: Twist) -> None:
        """Keep what the model asks for, and when it arrived."""
        ### BEGIN SOLUTION
        self.command = command
        self.command_arrival = self.get_clock().now()
        ### SKELETON
        # # TODO(task 2): keep the command, and the time at which it arrived.
        ### END SOLUTION

    def scan_callback(self, scan: LaserScan) -> None:
        """Keep the distance ahead, and when it arrived."""
        ### BEGIN SOLUTION
        self.distance = front_distance(scan, self.front_in(scan.header.frame_id))
        self.scan_arrival = self.get_clock().now()
        ### SKELETON
        # # TODO(task 2): keep the distance ahead, and the time at which the scan arrived.
        ### END SOLUTION

    def front_in(self, frame: str) -> float:
        """Return at which angle of a frame the robot's front is [rad]; 0 if nobody tells."""
        ### BEGIN SOLUTION
        try:
            robot = self.transforms.lookup_transform(frame, ROBOT_FRAME, Time())
        except TransformException:
            return 0.0
        return yaw_of(robot.transform.rotation)
        ### SKELETON
        # # TODO(task 2): self.transforms knows where ROBOT_FRAME is in that frame.
        # return 0.0
        ### END SOLUTION

    def e_stop_callback(self, message: Bool) -> None:
        """Keep whether the button is pressed."""
        ### BEGIN SOLUTION
        self.e_stop = message.data
        ### SKELETON
        # # TODO(task 2): keep what the button says now.
        ### END SOLUTION

    def age_of(self, arrival: Time | None) -> float:
        """Return how long ago that was [s]; ``inf`` for what never arrived."""
        ### BEGIN SOLUTION
        if arrival is None:
            return math.inf
        return (self.get_clock().now() - arrival).nanoseconds * 1e-9
        ### SKELETON
        # # TODO(task 2): the node's clock tells the time: self.get_clock().now().
        # return math.inf
        ### END SOLUTION

    def control_callback(self) -> None:
        """Run every 50 ms: one Twist, whatever has arrived, and a report where one is due."""
        decision = decide(
            Situation(
                e_stop=self.e_stop,
                command=self.command,
                command_age=self.age_of(self.command_arrival),
                distance=self.distance,
                scan_age=self.age_of(self.scan_arrival),
                last_speed=self.last_speed,
            )
        )
        self.drive(decision)
        if decision.reason != self.reported or self.age_of(self.report_time) >= REPORT_PERIOD:
            self.report(decision)

    def drive(self, decision: Decision) -> None:
        """Publish the command, and remember its speed for the next tick."""
        ### BEGIN SOLUTION
        twist = Twist()
        twist.linear.x = decision.speed
        twist.angular.z = decision.turn_rate
        self.cmd_vel_publisher.publish(twist)
        self.last_speed = decision.speed
        ### SKELETON
        # # TODO(task 1): publish a Twist with the decision's speed and turn rate;
        # # keep the speed in self.last_speed.
        ### END SOLUTION

    def report(self, decision: Decision) -> None:
        """Publish the reason: one status whose message begins with the reason word."""
        ### BEGIN SOLUTION
        status = DiagnosticStatus()
        status.level = LEVELS.get(decision.reason, DiagnosticStatus.ERROR)  # bytes, not an int
        status.name = "safety_supervisor: command"
        status.message = f"{decision.reason}: {decision.speed:.2f} m/s"
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics_publisher.publish(message)
        self.reported, self.report_time = decision.reason, self.get_clock().now()
        ### SKELETON
        # # TODO(task 5): publish a DiagnosticArray with one status;
        # # keep self.reported and self.report_time.
        ### END SOLUTION

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        self.cmd_vel_publisher.publish(Twist())


def main(args: list[str] | None = None) -> None:
    """Run the supervisor until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = SafetySupervisor()
    try:
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=1.0)  # a signal takes effect between two waits
    except KeyboardInterrupt:
        pass
    finally:
        node.stop()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
