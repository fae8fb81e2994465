"""One of the shuttle's three programs, as a launch file starts it; exercise 11 is judged with them.

Which one: the file's own name says it, or the first argument. Its parameters have other defaults
than students' have, and take any type; what they are, it prints.
"""

import json
import math
import sys
from pathlib import Path
from typing import Any

import rclpy
from geometry_msgs.msg import Twist
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

PARAMETERS = {"driver": {"cruise_speed": 0.15, "stop_distance": 0.45}, "guard": {"max_speed": 0.1}}


class Part(Node):  # type: ignore[misc]
    """Has the ends and the parameters of its namesake; only the watcher says anything."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        match name:
            case "watcher":
                self.publisher = self.create_publisher(Float64, "distance", 10)
                self.create_subscription(LaserScan, "scan", self.watch, qos_profile_sensor_data)
            case "driver":
                self.create_publisher(Twist, "cmd_vel", 10)
                self.create_subscription(Float64, "distance", lambda distance: None, 10)
            case "guard":
                self.create_publisher(Twist, "cmd_vel", 10)
                self.create_subscription(Twist, "cmd_vel_raw", lambda wish: None, 10)
            case _:  # the launch file starts one more: it is to be seen
                self.create_publisher(Float64, "~/unknown", 10)
        any_type = ParameterDescriptor(dynamic_typing=True)
        for parameter, default in PARAMETERS.get(name, {}).items():
            value: Any = self.declare_parameter(parameter, default, any_type).value
            if value != default:
                print(json.dumps({parameter: value}, default=str), flush=True)

    def watch(self, scan: LaserScan) -> None:
        """Tell the smallest usable distance ahead, if there is one."""
        angles = (scan.angle_min + i * scan.angle_increment for i in range(len(scan.ranges)))
        ahead = [abs(math.remainder(angle, math.tau)) <= math.pi / 2 for angle in angles]
        usable = [
            max(0.0, reading)
            for reading, counts in zip(scan.ranges, ahead, strict=True)
            if counts and (math.isinf(reading) or scan.range_min <= reading <= scan.range_max)
        ]
        if usable:
            self.publisher.publish(Float64(data=min(usable)))


def main() -> None:
    """Play the part until the trial ends."""
    stem = Path(__file__).stem
    name = sys.argv[1] if stem == "shuttle_part" else stem
    try:
        rclpy.init()
        rclpy.spin(Part(name))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
