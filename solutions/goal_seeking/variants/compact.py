"""As little code as the contract allows.

field: all
"""

import math

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data


class Agent(Node):
    def __init__(self):
        super().__init__("goal_seeking_agent")
        self.pose = None
        self.goal = None
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.odom_callback, qos_profile_sensor_data)
        self.create_subscription(PoseStamped, "/goal_pose", self.goal_callback, 10)
        self.create_timer(0.1, self.control_callback)

    def odom_callback(self, odom):
        p = odom.pose.pose.position
        q = odom.pose.pose.orientation
        yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
        if math.isfinite(p.x) and math.isfinite(p.y) and math.isfinite(yaw):
            self.pose = (p.x, p.y, yaw)
            self.heard = self.get_clock().now()
        else:
            self.get_logger().warning("pose is not finite")

    def goal_callback(self, message):
        p = message.pose.position
        if math.isfinite(p.x) and math.isfinite(p.y):
            self.goal = (p.x, p.y)
        else:
            self.get_logger().warning("goal is not finite")

    def control_callback(self):
        if self.pose is None or self.goal is None:
            return
        x, y, yaw = self.pose
        distance = math.hypot(self.goal[0] - x, self.goal[1] - y)
        twist = Twist()
        if distance <= 0.5:
            self.get_logger().info("Goal reached!")
            self.goal = None
        else:
            error = math.remainder(math.atan2(self.goal[1] - y, self.goal[0] - x) - yaw, math.tau)
            twist.linear.x = min(0.3, 0.5 * distance)
            twist.angular.z = max(-1.9, min(1.9, 2.0 * error))
        if (self.get_clock().now() - self.heard).nanoseconds > 0.5e9:
            twist = Twist()
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = Agent()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
