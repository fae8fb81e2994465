"""Style: the plane as complex numbers (numpy); the timer only runs while there is a goal.

field: all
"""

import cmath

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data


class GoalSeekingAgent(Node):
    def __init__(self) -> None:
        super().__init__("goal_seeking_agent")
        self.position: complex | None = None  # [m] x + iy
        self.heading = 1 + 0j  # unit vector the robot looks along
        self.goal = 0j  # [m]
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.odom_callback, qos_profile_sensor_data)
        self.create_subscription(PoseStamped, "/goal_pose", self.goal_callback, 10)
        self.timer = self.create_timer(0.1, self.control_callback)
        self.timer.cancel()  # nothing to do yet

    def odom_callback(self, odom: Odometry) -> None:
        p, q = odom.pose.pose.position, odom.pose.pose.orientation
        position = complex(p.x, p.y)
        heading = complex(q.w, q.z) ** 2  # half angles, squared: whole angles
        if not (cmath.isfinite(position) and cmath.isfinite(heading)):
            self.get_logger().warning("Ignored a pose that is not finite")
            return
        self.position, self.heading = position, heading

    def goal_callback(self, message: PoseStamped) -> None:
        goal = complex(message.pose.position.x, message.pose.position.y)
        if not cmath.isfinite(goal):
            self.get_logger().warning("Ignored a goal that is not finite")
            return
        self.goal = goal
        if self.timer.is_canceled():
            self.timer.reset()

    def control_callback(self) -> None:
        if self.position is None:
            return
        way = self.goal - self.position
        twist = Twist()
        if abs(way) <= 0.5:
            self.timer.cancel()
            self.get_logger().info("Goal reached!")
        else:
            error = np.angle(way / self.heading)  # [rad] in (-π, π], no wrapping to be done
            twist.linear.x = min(0.3, 0.5 * abs(way))
            twist.angular.z = float(np.clip(1.5 * error, -1.9, 1.9))
        self.publisher.publish(twist)


def main(args=None) -> None:
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
