"""A frozen dataclass is replaced as a whole; a bad start is logged, and the default is used.

field: all
"""

import math
from dataclasses import asdict, dataclass, replace

import rclpy
from geometry_msgs.msg import Twist
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

RANGES = {"cruise_speed": (0.0, 0.5), "stop_distance": (0.3, 2.0), "slow_distance": (0.3, 4.0)}


@dataclass(frozen=True)
class Settings:
    cruise_speed: float = 0.3
    stop_distance: float = 0.5
    slow_distance: float = 1.0

    def problem(self):
        for name, value in asdict(self).items():
            low, high = RANGES[name]
            if not low <= value <= high:  # also true for NaN
                return f"{name} = {value}: expected {low} to {high}"
        return "slow_distance < stop_distance" if self.slow_distance < self.stop_distance else ""

    def speed(self, distance):
        if distance < self.stop_distance:
            return 0.0
        return self.cruise_speed / (2.0 if distance < self.slow_distance else 1.0)


class Agent(Node):
    def __init__(self):
        super().__init__("live_parameters_agent")
        values = {}
        for name, default in asdict(Settings()).items():
            low, high = RANGES[name]
            span = FloatingPointRange(from_value=low, to_value=high)
            about = ParameterDescriptor(description=name, floating_point_range=[span])
            try:
                values[name] = self.declare_parameter(name, default, about).value
            except (InvalidParameterValueException, InvalidParameterTypeException) as error:
                self.get_logger().error(f"{error}; going on with {default}")
                self.declare_parameter(name, default, about, ignore_override=True)
        self.settings = Settings(**values)
        if problem := self.settings.problem():
            self.get_logger().error(f"{problem}; going on with the defaults")
            self.settings = Settings()
        self.add_on_set_parameters_callback(self.on_set)
        self.add_post_set_parameters_callback(self.after_set)
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)

    def with_new(self, parameters):
        new = {p.name: p.value for p in parameters if p.name in RANGES}
        return replace(self.settings, **new)

    def on_set(self, parameters):
        problem = self.with_new(parameters).problem()
        return SetParametersResult(successful=not problem, reason=problem)

    def after_set(self, parameters):
        self.settings = self.with_new(parameters)

    def on_scan(self, scan):
        nearest = math.inf
        seen = False
        for i, r in enumerate(scan.ranges):
            if math.cos(scan.angle_min + i * scan.angle_increment) < -1e-6:
                continue
            if math.isinf(r) or scan.range_min <= r <= scan.range_max:
                nearest, seen = min(nearest, max(r, 0.0)), True
        twist = Twist()
        twist.linear.x = self.settings.speed(nearest) if seen else 0.0
        self.publisher.publish(twist)


def main():
    rclpy.init()
    rclpy.spin(Agent())


if __name__ == "__main__":
    main()
