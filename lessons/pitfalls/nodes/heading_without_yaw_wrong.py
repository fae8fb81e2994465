"""Goal seeking: drives to the latest goal, says so, and waits for the next."""

import math

import rclpy
from geometry_msgs.msg import Pose, PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data


def finite(pose: Pose) -> bool:
    """Tell whether a pose says something."""
    p, q = pose.position, pose.orientation
    return all(math.isfinite(number) for number in (p.x, p.y, q.x, q.y, q.z, q.w))


class GoalSeekingAgent(Node):
    def __init__(self) -> None:
        super().__init__("goal_seeking_agent")
        self.pose: Pose | None = None
        self.goal: Pose | None = None
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.odom_callback, qos_profile_sensor_data)
        self.create_subscription(PoseStamped, "/goal_pose", self.goal_callback, 10)
        self.create_timer(0.1, self.control_callback)

    def odom_callback(self, odom: Odometry) -> None:
        if finite(odom.pose.pose):
            self.pose = odom.pose.pose
        else:
            self.get_logger().warning("Ignored a pose that is not finite")

    def goal_callback(self, message: PoseStamped) -> None:
        position = message.pose.position
        if math.isfinite(position.x) and math.isfinite(position.y):
            self.goal = message.pose
        else:
            self.get_logger().warning("Ignored a goal that is not finite")

    def control_callback(self) -> None:
        if self.pose is None or self.goal is None:
            return
        dx = self.goal.position.x - self.pose.position.x
        dy = self.goal.position.y - self.pose.position.y
        distance = math.hypot(dx, dy)

        twist = Twist()
        if distance <= 0.5:
            self.goal = None
            self.get_logger().info("Goal reached!")
        else:
            twist.linear.x = min(0.3, 0.5 * distance)
            twist.angular.z = max(-1.9, min(1.9, 2.0 * self.turn(dx, dy)))
        self.publisher.publish(twist)

    def turn(self, dx: float, dy: float) -> float:
        """Return how far to turn to face a goal that is dx, dy away [rad]."""
        return math.atan2(dy, dx)


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    node = GoalSeekingAgent()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
