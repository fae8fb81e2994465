"""Style: callback groups and a MultiThreadedExecutor, the shared state behind one lock.

field: all
"""

import math
from dataclasses import dataclass
from threading import Lock

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data


@dataclass
class Belief:
    """What the agent knows, always read and written under the lock."""

    pose: tuple[float, float, float] | None = None  # x, y [m], yaw [rad]
    heard: float = 0.0  # when the pose came [s]
    goal: tuple[float, float] | None = None  # x, y [m]


class GoalSeekingAgent(Node):
    def __init__(self) -> None:
        super().__init__("goal_seeking_agent")
        self.belief = Belief()
        self.lock = Lock()
        inputs = MutuallyExclusiveCallbackGroup()
        control = MutuallyExclusiveCallbackGroup()
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(
            Odometry, "/odom", self.odom_callback, qos_profile_sensor_data, callback_group=inputs
        )
        self.create_subscription(
            PoseStamped, "/goal_pose", self.goal_callback, 10, callback_group=inputs
        )
        self.create_timer(0.1, self.control_callback, callback_group=control)

    def odom_callback(self, odom: Odometry) -> None:
        p, q = odom.pose.pose.position, odom.pose.pose.orientation
        pose = (p.x, p.y, math.atan2(2.0 * q.w * q.z, 1.0 - 2.0 * q.z * q.z))
        if not all(map(math.isfinite, pose)):
            self.get_logger().warning("Ignored a pose that is not finite")
            return
        with self.lock:
            self.belief.pose = pose
            self.belief.heard = self.now()

    def now(self) -> float:
        return self.get_clock().now().nanoseconds / 1e9

    def goal_callback(self, message: PoseStamped) -> None:
        goal = (message.pose.position.x, message.pose.position.y)
        if not all(map(math.isfinite, goal)):
            self.get_logger().warning("Ignored a goal that is not finite")
            return
        with self.lock:
            self.belief.goal = goal

    def control_callback(self) -> None:
        with self.lock:
            pose, goal = self.belief.pose, self.belief.goal
            if pose is None or goal is None:
                return
            distance = math.dist(pose[:2], goal)
            age = self.now() - self.belief.heard
            if distance <= 0.5:
                self.belief.goal = None
        twist = Twist()
        if distance > 0.5 and age < 0.5:
            bearing = math.atan2(goal[1] - pose[1], goal[0] - pose[0])
            error = math.remainder(bearing - pose[2], math.tau)
            twist.linear.x = min(0.3, 0.5 * distance)
            twist.angular.z = math.copysign(min(1.9, 2.5 * abs(error)), error)
        elif distance <= 0.5:
            self.get_logger().info("Goal reached!")
        self.publisher.publish(twist)


def main(args=None) -> None:
    rclpy.init(args=args)
    node = GoalSeekingAgent()
    executor = MultiThreadedExecutor()
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
