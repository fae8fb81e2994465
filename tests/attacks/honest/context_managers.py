"""Everything in context managers, with a context of ROS's own."""

import contextlib

import rclpy
from geometry_msgs.msg import Twist
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan


@contextlib.contextmanager
def ros():
    context = Context()
    rclpy.init(context=context)
    try:
        yield context
    finally:
        rclpy.try_shutdown(context=context)


@contextlib.contextmanager
def running(context):
    node = Node("obstacle_avoidance_agent", context=context)
    cmd_vel = node.create_publisher(Twist, "/cmd_vel", 10)

    def on_scan(scan):
        twist = Twist()
        twist.linear.x = right_speed(scan)
        cmd_vel.publish(twist)

    node.create_subscription(LaserScan, "/scan", on_scan, qos_profile_sensor_data)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield executor
    node.destroy_node()


with ros() as context, running(context) as executor:
    executor.spin()
