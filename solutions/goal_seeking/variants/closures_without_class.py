"""Style: functions and closures, no class (rclpy.create_node), state in nonlocal variables.

field: all
"""

from math import atan2, cos, hypot, isfinite, sin

import rclpy
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("goal_seeking_agent")
    log = node.get_logger()
    publisher = node.create_publisher(Twist, "/cmd_vel", 10)
    pose = goal = None
    heard = 0  # [ns] when the pose came

    def on_odom(odom):
        nonlocal pose, heard
        p, q = odom.pose.pose.position, odom.pose.pose.orientation
        new = (p.x, p.y, 2.0 * atan2(q.z, q.w))  # a robot on the floor only turns about z
        if all(map(isfinite, new)):
            pose, heard = new, node.get_clock().now().nanoseconds
        else:
            log.warning("odometry is not finite, ignored")

    def on_goal(message):
        nonlocal goal
        new = (message.pose.position.x, message.pose.position.y)
        if all(map(isfinite, new)):
            goal = new
        else:
            log.warning("goal is not finite, ignored")

    def on_tick():
        nonlocal goal
        if pose is None or goal is None:
            return
        x, y, yaw = pose
        dx, dy = goal[0] - x, goal[1] - y
        distance = hypot(dx, dy)
        if distance <= 0.5:
            publisher.publish(Twist())
            log.info("Goal reached!")
            goal = None
            return
        if node.get_clock().now().nanoseconds - heard > 5e8:
            publisher.publish(Twist())
            return
        error = atan2(dy, dx) - yaw
        error = atan2(sin(error), cos(error))
        turn = max(-1.5, min(1.5, 3.0 * error))
        publisher.publish(
            Twist(linear=Vector3(x=min(0.3, 0.5 * distance)), angular=Vector3(z=turn))
        )

    node.create_subscription(Odometry, "/odom", on_odom, qos_profile_sensor_data)
    node.create_subscription(PoseStamped, "/goal_pose", on_goal, 10)
    node.create_timer(0.1, on_tick)
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
