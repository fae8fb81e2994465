"""A generator that receives scans, a metaclass that registers nodes, slots, a walrus, a match."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan

nodes = []


class Registers(type):
    def __call__(cls, *arguments, **options):
        nodes.append(made := super().__call__(*arguments, **options))
        return made


class Agent(Node, metaclass=Registers):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.loop = self.perceive_and_act()
        next(self.loop)
        send = lambda scan: self.loop.send(scan)  # noqa: E731, PLW0108  (rclpy needs a signature)
        self.create_subscription(LaserScan, "/scan", send, qos_profile_sensor_data)

    def perceive_and_act(self):
        while True:
            scan = yield
            match right_speed(scan):
                case speed if speed >= 0.0:
                    twist = Twist()
                    twist.linear.x = speed
                    self.cmd_vel.publish(twist)


rclpy.init()
Agent()
rclpy.spin(*nodes)
