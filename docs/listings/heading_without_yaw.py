"""The robot turns by the bearing to the goal, whichever way it looks already."""

import math

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node


class GoalSeekingAgent(Node):
    def __init__(self):
        super().__init__("goal_seeking_agent")
        self.position = None
        self.goal = None
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.odom_callback, 10)
        self.create_subscription(PoseStamped, "/goal_pose", self.goal_callback, 10)
        self.create_timer(0.1, self.control_loop)

    def odom_callback(self, odometry):
        position = odometry.pose.pose.position
        if math.isfinite(position.x) and math.isfinite(position.y):
            self.position = position
        else:
            self.get_logger().warning("a pose that is not finite is ignored")

    def goal_callback(self, goal):
        position = goal.pose.position
        if math.isfinite(position.x) and math.isfinite(position.y):
            self.goal = position
        else:
            self.get_logger().warning("a goal that is not finite is ignored")

    def control_loop(self):
        if self.position is None or self.goal is None:
            return
        dx = self.goal.x - self.position.x
        dy = self.goal.y - self.position.y
        distance = math.hypot(dx, dy)

        twist = Twist()
        if distance <= 0.5:
            self.get_logger().info("Goal reached!")
            self.goal = None
        else:
            # the mistake
            heading = math.atan2(dy, dx)
            twist.angular.z = max(-1.9, min(1.9, 2.0 * heading))
            # the end of it
            twist.linear.x = min(0.3, 0.5 * distance)
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(GoalSeekingAgent())


if __name__ == "__main__":
    main()
