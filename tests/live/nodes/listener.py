"""Prints a line of JSON for each scan, odometry, clock and diagnostics that it hears.

listener.py RELIABILITY, which is "reliable" or "best_effort". A line on stdin asks a service or
sets a parameter of the robot; the answer is a line too:

reset | pause true | pause false | set NAME FLOAT
"""

import json
import math
import sys
import threading

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import SetBool, Trigger


def say(topic: str, **values: object) -> None:
    print(json.dumps({"topic": topic, **values}), flush=True)


def seconds(stamp) -> float:
    return stamp.sec + stamp.nanosec / 1e9


class Listener(Node):
    def __init__(self, reliability: str) -> None:
        super().__init__(f"listener_{reliability}")
        qos = QoSProfile(depth=50, reliability=ReliabilityPolicy[reliability.upper()])
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos)
        self.create_subscription(Odometry, "/odom", self.on_odom, qos)
        self.create_subscription(Clock, "/clock", self.on_clock, qos)
        self.create_subscription(DiagnosticArray, "/diagnostics", self.on_diagnostics, qos)
        self.asks = {
            "reset": self.create_client(Trigger, "/reset"),
            "pause": self.create_client(SetBool, "/pause"),
            "set": self.create_client(SetParameters, "/mock_robot/set_parameters"),
        }

    def on_scan(self, scan: LaserScan) -> None:
        finite = [r for r in scan.ranges if math.isfinite(r)]
        say("/scan", stamp=seconds(scan.header.stamp), beams=len(scan.ranges), nearest=min(finite))

    def on_odom(self, odom: Odometry) -> None:
        position, twist = odom.pose.pose.position, odom.twist.twist
        say(
            "/odom",
            stamp=seconds(odom.header.stamp),
            x=position.x,
            y=position.y,
            v=twist.linear.x,
            w=twist.angular.z,
        )

    def on_clock(self, clock: Clock) -> None:
        say("/clock", stamp=seconds(clock.clock))

    def on_diagnostics(self, array: DiagnosticArray) -> None:
        for status in array.status:
            level = int.from_bytes(status.level, "little")
            say("/diagnostics", name=status.name, level=level, message=status.message)

    def ask(self, line: str) -> None:
        name, *words = line.split()
        client = self.asks[name]
        client.wait_for_service()
        future = client.call_async(self.request(name, words))
        future.add_done_callback(lambda done: self.answer(name, done.result()))

    def request(self, name: str, words: list[str]):
        if name == "reset":
            return Trigger.Request()
        if name == "pause":
            return SetBool.Request(data=words[0] == "true")
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=float(words[1]))
        return SetParameters.Request(parameters=[Parameter(name=words[0], value=value)])

    def answer(self, name: str, response) -> None:
        if name == "set":
            (result,) = response.results
            say("answer", success=result.successful, message=result.reason)
        else:
            say("answer", success=response.success, message=response.message)


def read_orders(node: Listener) -> None:
    for line in sys.stdin:
        node.ask(line)


rclpy.init()
node = Listener(sys.argv[1])
threading.Thread(target=read_orders, args=(node,), daemon=True).start()
rclpy.spin(node)
