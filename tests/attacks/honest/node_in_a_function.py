"""No class of its own: everything is made in a function, the callback is a closure."""

import functools

import rclpy
from geometry_msgs.msg import Twist
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan


def main():
    rclpy.init()
    node = rclpy.create_node("obstacle_avoidance_agent")
    publisher = node.create_publisher(Twist, "/cmd_vel", 10)

    def on_scan(publish, scan):
        publish(Twist(linear=type(Twist().linear)(x=right_speed(scan))))

    callback = functools.partial(on_scan, publisher.publish)
    node.create_subscription(LaserScan, "/scan", callback, qos_profile_sensor_data)
    try:
        while rclpy.ok():
            rclpy.spin_once(node)
    finally:
        node.destroy_node()


main()
