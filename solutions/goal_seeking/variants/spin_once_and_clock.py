"""Style: no timer object; a spin_once loop in main that watches get_clock() for the next tick.

field: all
"""

import math

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

PERIOD = Duration(seconds=0.1)


class Seeker(Node):
    def __init__(self):
        super().__init__("goal_seeking_agent")
        self.pose = None  # (x [m], y [m], yaw [rad])
        self.goal = None  # (x [m], y [m])
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Odometry, "/odom", self.on_odom, qos_profile_sensor_data)
        self.create_subscription(PoseStamped, "/goal_pose", self.on_goal, 10)

    def on_odom(self, msg):
        q = msg.pose.pose.orientation
        yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
        pose = (msg.pose.pose.position.x, msg.pose.pose.position.y, yaw)
        if all(math.isfinite(value) for value in pose):
            self.pose = pose
        else:
            self.get_logger().warning("pose is not finite")

    def on_goal(self, msg):
        goal = (msg.pose.position.x, msg.pose.position.y)
        if all(math.isfinite(value) for value in goal):
            self.goal = goal
        else:
            self.get_logger().warning("goal is not finite")

    def tick(self):
        if self.pose is None or self.goal is None:
            return
        x, y, yaw = self.pose
        distance = math.hypot(self.goal[0] - x, self.goal[1] - y)
        command = Twist()
        if distance <= 0.5:
            self.goal = None
            self.get_logger().info("Goal reached!")
        else:
            error = math.atan2(self.goal[1] - y, self.goal[0] - x) - yaw
            error = math.atan2(math.sin(error), math.cos(error))
            command.linear.x = min(0.3, 0.5 * distance)
            command.angular.z = max(-1.9, min(1.9, 4.0 * error))
        self.publisher.publish(command)


def main(args=None):
    rclpy.init(args=args)
    node = Seeker()
    clock = node.get_clock()
    next_tick = clock.now() + PERIOD
    try:
        while rclpy.ok():
            wait = (next_tick - clock.now()).nanoseconds * 1e-9  # [s]
            if wait > 0.0:
                rclpy.spin_once(node, timeout_sec=wait)
            else:
                node.tick()
                next_tick += PERIOD
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
