"""Sends what the course's nodes ask for, and prints a line of JSON for each Twist that they send.

course.py NAME…   listens on /NAME/cmd_vel. A line on stdin is an order; the answer is a line too:

begin             from now on there are scans, odometry, goals and raw commands
rest              wait until the newest command of each name is zero
meet NAME         wait until the node of this name answers a request: it spins
"""

import json
import math
import sys
import threading

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import ListParameters
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

PERIOD = 0.1  # [s]
DISTANCE = 5.0  # [m] to whatever is around, and to the goal


def say(topic: str, **values: object) -> None:
    print(json.dumps({"topic": topic, **values}), flush=True)


class Course(Node):
    def __init__(self, names: list[str]) -> None:
        super().__init__("course")
        self.largest = dict.fromkeys(names, math.inf)  # field of the newest command
        self.asked_for_rest = False
        self.scans = self.create_publisher(LaserScan, "/scan", 10)
        self.odometry = self.create_publisher(Odometry, "/odom", 10)
        self.goals = self.create_publisher(PoseStamped, "/goal_pose", 10)
        self.raw_commands = self.create_publisher(Twist, "/cmd_vel_raw", 10)
        for name in names:
            self.create_subscription(
                Twist, f"/{name}/cmd_vel", lambda twist, name=name: self.on_twist(name, twist), 10
            )

    def obey(self, order: str, *names: str) -> None:
        if order == "begin":
            self.create_timer(PERIOD, self.send)
            say("answer")
        elif order == "rest":
            self.asked_for_rest = True
            self.tell_of_rest()
        else:
            client = self.create_client(ListParameters, f"/{names[0]}/list_parameters")
            client.wait_for_service()
            future = client.call_async(ListParameters.Request())
            future.add_done_callback(lambda _: say("answer"))

    def send(self) -> None:
        scan = LaserScan(
            angle_min=-3.14,
            angle_increment=0.0175,
            range_min=0.15,
            range_max=12.0,
            ranges=[DISTANCE] * 360,
        )
        scan.header.stamp = self.get_clock().now().to_msg()
        self.scans.publish(scan)
        odometry, goal, raw_command = Odometry(), PoseStamped(), Twist()
        goal.pose.position.x = DISTANCE
        raw_command.linear.x = 0.3
        self.odometry.publish(odometry)
        self.goals.publish(goal)
        self.raw_commands.publish(raw_command)

    def on_twist(self, name: str, twist: Twist) -> None:
        linear, angular = twist.linear, twist.angular
        fields = linear.x, linear.y, linear.z, angular.x, angular.y, angular.z
        self.largest[name] = max(map(abs, fields))
        say(f"/{name}/cmd_vel", largest=self.largest[name])
        self.tell_of_rest()

    def tell_of_rest(self) -> None:
        if self.asked_for_rest and not any(self.largest.values()):
            say("answer")


def read_orders(node: Course) -> None:
    for line in sys.stdin:
        node.obey(*line.split())


rclpy.init()
node = Course(sys.argv[1:])
threading.Thread(target=read_orders, args=(node,), daemon=True).start()
rclpy.spin(node)
