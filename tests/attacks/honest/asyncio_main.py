"""Runs ROS under asyncio: spins a little, lets other coroutines go on, and so forth."""

import asyncio

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan


class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = right_speed(scan)
        self.cmd_vel.publish(twist)


async def spin(executor):
    while rclpy.ok():
        executor.spin_once(timeout_sec=0)
        await asyncio.sleep(0.005)


async def main():
    rclpy.init()
    executor = SingleThreadedExecutor()
    executor.add_node(Agent())
    await asyncio.gather(spin(executor), asyncio.sleep(1.0))


asyncio.run(main())
