"""Trend memory: an agent that remembers its last ten readings, and so sees what is coming.

Subscribes  /scan           sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   /closing_speed  std_msgs/msg/Float64       how fast what is ahead comes closer [m/s]
            /cmd_vel        geometry_msgs/msg/Twist    forward speed [m/s], one for each scan
"""

import math
import signal
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

MEMORY_SIZE = 10  # readings
LONGEST_GAP = 1.0  # [s] a stamp that jumps ahead by more begins a new memory
STOP_DISTANCE = 0.5  # [m] nearer than this: stop
LEAST_TIME = 2.0  # [s] to a collision; with less than this: stop
SPEED = 0.3  # [m/s]
FRONT_HALF_ANGLE = math.pi / 2  # [rad] "ahead" is everything within ±90°


class Reading(NamedTuple):
    """One remembered scan."""

    stamp: float  # [s] when it was measured, as the scan's header says
    distance: float  # [m] to the nearest thing ahead


def front_distance(scan: LaserScan) -> float | None:
    """Return the smallest usable distance ahead [m], as in exercise 1; None: nothing is usable."""
    usable = []
    for index, reading in enumerate(scan.ranges):
        angle = math.remainder(scan.angle_min + index * scan.angle_increment, math.tau)
        if abs(angle) > FRONT_HALF_ANGLE:
            continue
        if reading == -math.inf:
            usable.append(0.0)
        elif reading == math.inf or scan.range_min <= reading <= scan.range_max:
            usable.append(reading)
    return min(usable, default=None)


def closing_speed(readings: Sequence[Reading]) -> float:
    """Return how fast the distance shrinks over these readings [m/s]; negative: it grows.

    It is minus the slope of the least-squares line through the points (stamp, distance).

    A stamp is about 1.7e9 s. Its square leaves no digits for milliseconds in a float, so count
    the time from the mean of the stamps.
    """
    # TODO(task 3): fit the line; return minus its slope.
    return 0.0


def choose_speed(distance: float | None, closing: float | None) -> float:
    """Return the forward speed [m/s] for a distance ahead [m] and a closing speed [m/s].

    0.0 below 0.5 m, with less than 2.0 s to a collision, or blind (distance None); otherwise 0.3.
    The closing speed is None while it is not known.
    """
    # TODO(task 4): blind? too near? too soon? Otherwise SPEED.
    return 0.0


class TrendAgent(Node):
    """Drives straight ahead, and stops for what is near or soon will be."""

    def __init__(self) -> None:
        super().__init__("trend_agent")
        # TODO(task 1): create publishers of Twist on /cmd_vel and of Float64 on /closing_speed,
        # and a subscription to LaserScan on /scan that calls self.scan_callback.
        # TODO(task 2): and a memory for the last MEMORY_SIZE readings.
        self.get_logger().info("Trend agent started")

    def scan_callback(self, scan: LaserScan) -> None:
        """Remember, compare, act. Exactly one Twist for each scan."""
        distance = front_distance(scan)
        stamp = scan.header.stamp.sec + scan.header.stamp.nanosec * 1e-9
        closing = self.remember(stamp, distance)
        speed = choose_speed(distance, closing)
        self.drive(speed)
        if distance is None:
            self.get_logger().warning(
                "No usable reading ahead, velocity: 0.00 m/s", throttle_duration_sec=1.0
            )
        else:
            self.get_logger().info(f"Distance: {distance:.2f} m, velocity: {speed:.2f} m/s")

    def remember(self, stamp: float, distance: float | None) -> float | None:
        """Add a reading to the memory; publish and return the closing speed [m/s] if it is known.

        Parameters
        ----------
        stamp
            When the scan was measured [s]. A stamp before that of the previous scan, or more than
            1 s after it, empties the memory first.
        distance
            To the nearest thing ahead [m]. None and ``inf`` are not remembered.

        Returns
        -------
        float | None
            None without a reading to remember, and while there are fewer than ten.
        """
        # TODO(task 2): remember the reading, if there is one to remember.
        # TODO(task 3): with ten readings, publish closing_speed(…) on /closing_speed, once.
        # TODO(task 5): before all that, empty the memory if the stamp has jumped.
        return None

    def drive(self, speed: float) -> None:
        """Publish one Twist with ``linear.x`` = speed [m/s] and every other field 0."""
        # TODO(task 4): fill in a Twist and publish it.

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        self.drive(0.0)


def main(args: list[str] | None = None) -> None:
    """Run the agent until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = TrendAgent()
    try:
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=1.0)  # a signal takes effect between two waits
    except KeyboardInterrupt:
        pass
    finally:
        node.stop()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
