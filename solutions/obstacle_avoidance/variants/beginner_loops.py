"""Style: a careful beginner, plain loops and ifs, everything in one callback.

field: field_lds01, field_wide_lidar, field_mirrored_world, field_speckle, field_lost_scans
"""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class MyAgent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.sub = self.create_subscription(LaserScan, "/scan", self.callback, 10)
        self.get_logger().info("hello, I am the agent")

    def callback(self, msg):
        smallest = 1000000.0
        found = False
        angle = msg.angle_min
        for r in msg.ranges:
            # bring the angle to -pi ... pi
            a = angle
            while a > math.pi:
                a = a - 2 * math.pi
            while a < -math.pi:
                a = a + 2 * math.pi
            angle = angle + msg.angle_increment

            if a < -math.pi / 2 or a > math.pi / 2:
                continue  # behind me
            if math.isnan(r):
                continue  # broken reading
            if r == float("inf"):
                found = True  # nothing there, good
                continue
            if r == float("-inf"):
                r = 0.0  # too close to measure
            elif r < msg.range_min or r > msg.range_max:
                continue
            found = True
            if r < smallest:
                smallest = r

        if not found:
            speed = 0.0
            self.get_logger().warning("I am blind, stopping")
        elif smallest < 0.5:
            speed = 0.0
        elif smallest < 1.0:
            speed = 0.15
        else:
            speed = 0.5

        t = Twist()
        t.linear.x = speed
        self.pub.publish(t)
        self.get_logger().info("distance " + str(smallest) + " velocity " + str(speed))


def main(args=None):
    rclpy.init(args=args)
    node = MyAgent()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
