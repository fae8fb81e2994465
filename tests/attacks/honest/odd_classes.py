"""Base classes, a metaclass that registers nodes, a dataclass, and a generator that takes scans."""

import abc
from dataclasses import dataclass, field

import rclpy
from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from seeing import right_speed
from sensor_msgs.msg import LaserScan

nodes = []


class Decides(abc.ABC):
    @abc.abstractmethod
    def decide(self, scan): ...


class Cautious(Decides):
    def decide(self, scan):
        return right_speed(scan)


class Acts:
    def act(self, speed):
        self.cmd_vel.publish(Twist(linear=Vector3(x=speed)))


class Registers(abc.ABCMeta):
    def __call__(cls, *arguments, **options):
        nodes.append(made := super().__call__(*arguments, **options))
        return made


@dataclass(eq=False)
class Agent(Cautious, Acts, Node, metaclass=Registers):
    name: str = "obstacle_avoidance_agent"
    history: list[float] = field(default_factory=list)

    def __post_init__(self):
        Node.__init__(self, self.name)
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.loop = self.perceive_and_act()
        next(self.loop)
        send = lambda scan: self.loop.send(scan)  # noqa: E731, PLW0108  (rclpy needs a signature)
        self.create_subscription(LaserScan, "/scan", send, qos_profile_sensor_data)

    def perceive_and_act(self):
        while True:
            scan = yield
            match self.decide(scan):
                case speed if speed >= 0.0:
                    self.history.append(speed)
                    self.act(speed)


rclpy.init()
Agent()
rclpy.spin(*nodes)
