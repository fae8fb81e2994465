"""Live parameters: an agent whose speed and distances can be set before and while it drives.

Subscribes  /scan     sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   /cmd_vel  geometry_msgs/msg/Twist    forward speed [m/s], one for each scan
Parameters  cruise_speed [m/s], stop_distance [m], slow_distance [m]

    python3 live_parameters_agent.py --ros-args --params-file narrow_aisle.yaml
"""

import math
import signal

import rclpy
from geometry_msgs.msg import Twist
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan

PARAMETERS = {  # default, least, greatest, and what it is
    "cruise_speed": (0.3, 0.0, 0.5, "speed where the way is free [m/s]"),
    "stop_distance": (0.5, 0.3, 2.0, "nearer than this the robot stands [m]"),
    "slow_distance": (1.0, 0.3, 4.0, "nearer than this it drives at half the speed [m]"),
}
FASTEST = 0.5  # [m/s] whatever the parameters say
NEAREST = 0.3  # [m] nearer than this it stands, whatever the parameters say


def front_distance(scan: LaserScan) -> float | None:
    """Return the smallest usable distance within ±90° of ahead [m]; ``None``: blind."""
    usable = []
    for index, reading in enumerate(scan.ranges):
        angle = math.remainder(scan.angle_min + index * scan.angle_increment, math.tau)
        if abs(angle) > math.pi / 2:
            continue
        if reading == -math.inf:
            usable.append(0.0)
        elif reading == math.inf or scan.range_min <= reading <= scan.range_max:
            usable.append(reading)
    return min(usable, default=None)


class LiveParametersAgent(Node):
    """Drives ahead as its parameters say, within limits that no parameter can move."""

    def __init__(self) -> None:
        super().__init__("live_parameters_agent")
        # TODO(task 5): have self.check asked before any value is set, the first ones, too.
        for name, about in PARAMETERS.items():
            # TODO(task 2): a descriptor with the meaning and the range, least to greatest.
            self.declare_parameter(name, about[0])
        self.cmd_vel_publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        # TODO(task 1): a subscription to LaserScan on /scan that calls self.scan_callback.

    def check(self, parameters: list[Parameter]) -> SetParametersResult:
        """Say whether these may all be set, together; change nothing."""
        # TODO(task 5): refuse, with a reason, a slow_distance below the stop_distance.
        return SetParametersResult(successful=True)

    def choose_speed(self, distance: float | None) -> float:
        """Return the forward speed [m/s] for a distance ahead [m]; ``None``: blind."""
        # TODO(task 3): compare the distance with the parameters, as they are now (task 4).
        # TODO(task 6): keep to FASTEST and NEAREST, whatever they say.
        return 0.0

    def scan_callback(self, scan: LaserScan) -> None:
        """Perceive, decide, act: one Twist for each scan."""
        self.drive(self.choose_speed(front_distance(scan)))

    def drive(self, speed: float) -> None:
        """Publish one Twist with ``linear.x`` = speed [m/s] and every other field 0."""
        twist = Twist()
        twist.linear.x = speed
        self.cmd_vel_publisher.publish(twist)


def main(args: list[str] | None = None) -> None:
    """Run the agent until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = LiveParametersAgent()
    try:
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=1.0)  # a signal takes effect between two waits
    except KeyboardInterrupt:
        pass
    finally:
        node.drive(0.0)
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
