"""Perception, decision and action as three base classes, an abstract one among them."""

import abc

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan


class Decides(abc.ABC):
    @abc.abstractmethod
    def decide(self, scan): ...


class Cautious(Decides):
    def decide(self, scan):
        return right_speed(scan)


class Acts:
    def act(self, speed):
        twist = Twist()
        twist.linear.x = speed
        self.cmd_vel.publish(twist)


class Agent(Cautious, Acts, Node):
    def __init__(self):
        Node.__init__(self, "obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(
            LaserScan, "/scan", lambda scan: self.act(self.decide(scan)), qos_profile_sensor_data
        )


rclpy.init()
rclpy.spin(Agent())
