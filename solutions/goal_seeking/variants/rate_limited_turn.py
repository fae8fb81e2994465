"""Style: a rate limiter smooths angular.z; the forward speed follows the cosine of the error.

field: all
"""

import math

import rclpy
from geometry_msgs.msg import Point, PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

PERIOD = 0.1  # [s]
MAX_TURN_STEP = 0.5  # [rad/s] change of the turn rate in one period


class RateLimiter:
    """Follows a target, at most one step at a time."""

    def __init__(self, step: float) -> None:
        self.step = step
        self.value = 0.0

    def towards(self, target: float) -> float:
        change = max(-self.step, min(self.step, target - self.value))
        self.value += change
        return self.value


class GoalSeekingAgent(Node):
    def __init__(self) -> None:
        super().__init__("goal_seeking_agent")
        self.position: Point | None = None
        self.yaw = 0.0  # [rad]
        self.goal: Point | None = None
        self.turn = RateLimiter(MAX_TURN_STEP)
        best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.publisher = self.create_publisher(Twist, "cmd_vel", best_effort)
        self.create_subscription(Odometry, "odom", self.odom_callback, best_effort)
        self.create_subscription(PoseStamped, "goal_pose", self.goal_callback, 1)
        self.create_timer(PERIOD, self.control_callback)

    def odom_callback(self, odom: Odometry) -> None:
        pose = odom.pose.pose
        yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        if all(math.isfinite(v) for v in (pose.position.x, pose.position.y, yaw)):
            self.position, self.yaw = pose.position, yaw
        else:
            self.get_logger().warning("Ignored a pose that is not finite")

    def goal_callback(self, message: PoseStamped) -> None:
        goal = message.pose.position
        if math.isfinite(goal.x) and math.isfinite(goal.y):
            self.goal = goal
            self.turn = RateLimiter(MAX_TURN_STEP)
        else:
            self.get_logger().warning("Ignored a goal that is not finite")

    def control_callback(self) -> None:
        if self.position is None or self.goal is None:
            return
        dx = self.goal.x - self.position.x
        dy = self.goal.y - self.position.y
        distance = math.hypot(dx, dy)
        twist = Twist()
        if distance <= 0.5:
            self.goal = None
            self.get_logger().info("Goal reached!")
        else:
            error = math.remainder(math.atan2(dy, dx) - self.yaw, math.tau)
            target = max(-1.2, min(1.2, 1.5 * error))
            twist.angular.z = self.turn.towards(target)
            twist.linear.x = min(0.3, 0.5 * distance) * max(0.0, math.cos(error))
        self.publisher.publish(twist)


def main(args=None) -> None:
    rclpy.init(args=args)
    executor = SingleThreadedExecutor()
    executor.add_node(GoalSeekingAgent())
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
