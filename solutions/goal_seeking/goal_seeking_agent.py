"""Goal seeking: an agent that keeps state between its callbacks.

Subscribes  /odom       nav_msgs/msg/Odometry          where the robot is, frame odom [m]
            /goal_pose  geometry_msgs/msg/PoseStamped  where it is to go, frame odom [m]
Publishes   /cmd_vel    geometry_msgs/msg/Twist        [m/s] and [rad/s], 10 times a second
"""

import math
import signal
from typing import NamedTuple

import rclpy
from geometry_msgs.msg import PoseStamped, Quaternion, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions

CONTROL_PERIOD = 0.1  # [s] 10 Hz
GOAL_TOLERANCE = 0.5  # [m] within this distance the goal is reached
MAX_SPEED = 0.3  # [m/s]
MAX_TURN_RATE = 1.9  # [rad/s]
SPEED_GAIN = 0.5  # [1/s] speed for each metre still to go
TURN_GAIN = 2.0  # [1/s] turn rate for each radian of heading error


class Pose(NamedTuple):
    """Where the robot is and where it looks, in the frame odom."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad] left of the x axis is positive


class Goal(NamedTuple):
    """Where the robot is to go, in the frame odom."""

    x: float  # [m]
    y: float  # [m]


def yaw_of(q: Quaternion) -> float:
    """Return the rotation about the vertical axis [rad], in [-π, π], of a unit quaternion."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def distance_to(goal: Goal, pose: Pose) -> float:
    """Return the straight-line distance from the robot to the goal [m]."""
    ### BEGIN SOLUTION
    return math.hypot(goal.x - pose.x, goal.y - pose.y)
    ### SKELETON
    # # TODO(task 3): Pythagoras.
    # return 0.0
    ### END SOLUTION


def heading_error(goal: Goal, pose: Pose) -> float:
    """Return how far the robot has to turn to face the goal [rad], in [-π, π], left is positive.

    It is the bearing to the goal minus the robot's yaw, wrapped: a robot never needs to turn by
    more than half a circle.
    """
    ### BEGIN SOLUTION
    bearing = math.atan2(goal.y - pose.y, goal.x - pose.x)
    return math.remainder(bearing - pose.yaw, math.tau)
    ### SKELETON
    # # TODO(task 3): the bearing (math.atan2), minus the yaw, wrapped to [-π, π].
    # return 0.0
    ### END SOLUTION


class GoalSeekingAgent(Node):
    """Drives to the latest goal, stops there once, and is silent until the next goal."""

    def __init__(self) -> None:
        super().__init__("goal_seeking_agent")
        self.pose: Pose | None = None  # None: no odometry yet
        self.goal: Goal | None = None  # None: nothing to do
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        ### BEGIN SOLUTION
        # "Sensor data" QoS takes odometry from reliable and from best-effort publishers.
        self.odom_subscription = self.create_subscription(
            Odometry, "/odom", self.odom_callback, qos_profile_sensor_data
        )
        self.goal_subscription = self.create_subscription(
            PoseStamped, "/goal_pose", self.goal_callback, 10
        )
        self.control_timer = self.create_timer(CONTROL_PERIOD, self.control_callback)
        ### SKELETON
        # # TODO(task 1): subscribe to /odom and /goal_pose,
        # # and create a timer that calls self.control_callback every CONTROL_PERIOD seconds.
        ### END SOLUTION
        self.get_logger().info("Goal seeking agent started")

    def odom_callback(self, odom: Odometry) -> None:
        """Remember the newest pose. One that is not finite is ignored, with a warning."""
        ### BEGIN SOLUTION
        position = odom.pose.pose.position
        pose = Pose(position.x, position.y, yaw_of(odom.pose.pose.orientation))
        if not all(math.isfinite(number) for number in pose):
            self.get_logger().warning(
                f"Ignored a pose that is not finite: {pose}", throttle_duration_sec=1.0
            )
            return
        self.pose, self.heard = pose, self.get_clock().now()
        ### SKELETON
        # # TODO(task 2): keep the pose in self.pose, if it is finite.
        ### END SOLUTION

    def goal_callback(self, message: PoseStamped) -> None:
        """Start over with a new goal. One that is not finite is ignored, with a warning."""
        ### BEGIN SOLUTION
        position = message.pose.position
        goal = Goal(position.x, position.y)
        if not all(math.isfinite(number) for number in goal):
            self.get_logger().warning(f"Ignored a goal that is not finite: {goal}")
            return
        self.goal = goal
        self.get_logger().info(f"New goal: ({goal.x:.2f}, {goal.y:.2f})")
        ### SKELETON
        # # TODO(task 2): keep the goal in self.goal, if it is finite.
        ### END SOLUTION

    def control_callback(self) -> None:
        """Run every 0.1 s: publish one Twist on the way to a goal, nothing when there is none.

        On the way: ``linear.x`` = min(0.3, 0.5 · distance) [m/s], ``angular.z`` turns toward the
        goal, at most 1.9 rad/s. Within 0.5 m: one zero Twist, log "Goal reached!", then silence.
        """
        if self.pose is None or self.goal is None:
            return
        ### BEGIN SOLUTION
        twist = Twist()
        distance = distance_to(self.goal, self.pose)
        age = (self.get_clock().now() - self.heard).nanoseconds / 1e9  # [s] of the pose
        if distance <= GOAL_TOLERANCE:
            self.goal = None
            self.get_logger().info("Goal reached!")
        elif age <= 0.5:  # an older pose says nothing of where the robot is: it stands
            turn_rate = TURN_GAIN * heading_error(self.goal, self.pose)
            twist.linear.x = min(MAX_SPEED, SPEED_GAIN * distance)
            twist.angular.z = max(-MAX_TURN_RATE, min(MAX_TURN_RATE, turn_rate))
        self.cmd_vel_publisher.publish(twist)
        ### SKELETON
        # # TODO(task 4): fill in a Twist that drives and turns toward the goal, and publish it.
        # # TODO(task 5): arrived? One zero Twist, the log line, and then silence.
        ### END SOLUTION

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        self.cmd_vel_publisher.publish(Twist())


def main(args: list[str] | None = None) -> None:
    """Run the agent until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = GoalSeekingAgent()
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
