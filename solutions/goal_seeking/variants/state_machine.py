"""Style: a state machine with an enum; each state says what one tick does.

field: all
"""

import math
from enum import Enum, auto

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data


class State(Enum):
    IDLE = auto()  # no goal, or the goal is behind us
    SEEKING = auto()
    ARRIVING = auto()  # within the tolerance: the next thing to say is "stop"


class GoalSeekingAgent(Node):
    def __init__(self) -> None:
        super().__init__("goal_seeking_agent")
        self.state = State.IDLE
        self.x = self.y = self.yaw = math.nan
        self.goal_x = self.goal_y = math.nan
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.odom_callback, qos_profile_sensor_data)
        self.create_subscription(PoseStamped, "/goal_pose", self.goal_callback, 10)
        self.create_timer(0.1, self.tick_callback)
        self.get_logger().info("state machine ready")

    def odom_callback(self, odom: Odometry) -> None:
        p, q = odom.pose.pose.position, odom.pose.pose.orientation
        yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2))
        if not math.isfinite(p.x + p.y + yaw):
            self.get_logger().warning("pose is not finite")
            return
        self.x, self.y, self.yaw = p.x, p.y, yaw

    def goal_callback(self, message: PoseStamped) -> None:
        p = message.pose.position
        if not math.isfinite(p.x + p.y):
            self.get_logger().warning("goal is not finite")
            return
        self.goal_x, self.goal_y = p.x, p.y
        self.state = State.SEEKING

    def tick_callback(self) -> None:
        distance = math.hypot(self.goal_x - self.x, self.goal_y - self.y)
        if self.state is State.SEEKING and distance <= 0.5:
            self.state = State.ARRIVING
        match self.state:
            case State.SEEKING if math.isfinite(distance):
                self.seek(distance)
            case State.ARRIVING:
                self.publisher.publish(Twist())
                self.get_logger().info("Goal reached!")
                self.state = State.IDLE

    def seek(self, distance: float) -> None:
        error = math.atan2(self.goal_y - self.y, self.goal_x - self.x) - self.yaw
        error = (error + math.pi) % (2 * math.pi) - math.pi
        twist = Twist()
        twist.linear.x = min(0.3, 0.5 * distance)
        twist.angular.z = min(max(1.8 * error, -1.9), 1.9)
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
