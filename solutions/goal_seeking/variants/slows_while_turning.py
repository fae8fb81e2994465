"""Style: a careful beginner with wrapping loops, who stands still until the goal is ahead.

field: field_lost_odometry, field_mirrored_world, field_fast_odometry
"""

import math

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node


class GoalAgent(Node):
    def __init__(self):
        super().__init__("goal_seeking_agent")
        self.have_pose = False
        self.have_goal = False
        self.pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.odom_cb, 10)
        self.create_subscription(PoseStamped, "/goal_pose", self.goal_cb, 10)
        self.timer = self.create_timer(0.1, self.control)

    def odom_cb(self, msg):
        x = msg.pose.pose.position.x
        y = msg.pose.pose.position.y
        q = msg.pose.pose.orientation
        yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(yaw)):
            self.get_logger().warning("bad pose")
            return
        self.x = x
        self.y = y
        self.yaw = yaw
        self.have_pose = True

    def goal_cb(self, msg):
        gx = msg.pose.position.x
        gy = msg.pose.position.y
        if not math.isfinite(gx) or not math.isfinite(gy):
            self.get_logger().warning("bad goal")
            return
        self.gx = gx
        self.gy = gy
        self.have_goal = True

    def control(self):
        if not self.have_pose or not self.have_goal:
            return
        cmd = Twist()
        dx = self.gx - self.x
        dy = self.gy - self.y
        dist = math.sqrt(dx * dx + dy * dy)
        if dist < 0.5:
            self.pub.publish(cmd)
            self.get_logger().info("Goal reached!")
            self.have_goal = False
            return
        err = math.atan2(dy, dx) - self.yaw
        while err > math.pi:
            err = err - 2.0 * math.pi
        while err < -math.pi:
            err = err + 2.0 * math.pi
        cmd.angular.z = 1.5 * err
        if cmd.angular.z > 1.0:
            cmd.angular.z = 1.0
        if cmd.angular.z < -1.0:
            cmd.angular.z = -1.0
        # First turn, then drive.
        if abs(err) < 0.5:
            cmd.linear.x = min(0.3, 0.5 * dist)
        self.pub.publish(cmd)


def main(args=None):
    rclpy.init(args=args)
    node = GoalAgent()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
