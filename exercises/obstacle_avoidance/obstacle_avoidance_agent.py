"""Obstacle avoidance: the perception-decision-action loop of a reactive agent.

Subscribes  /scan     sensor_msgs/msg/LaserScan  distances all around the robot [m]
Publishes   /cmd_vel  geometry_msgs/msg/Twist    forward speed [m/s], one for each scan
"""

import math
import signal

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import LaserScan

STOP_DISTANCE = 0.5  # [m] nearer than this: stop
SLOW_DISTANCE = 1.0  # [m] nearer than this: slow down
FULL_SPEED = 0.5  # [m/s]
SLOW_SPEED = 0.15  # [m/s] 30 % of full speed
FRONT_HALF_ANGLE = math.pi / 2  # [rad] "ahead" is everything within ±90°


def front_distance(scan: LaserScan) -> float | None:
    """Perception: return the smallest usable distance ahead of the robot.

    Parameters
    ----------
    scan
        One turn of the lidar. Beam ``i`` points to ``angle_min + i * angle_increment`` [rad];
        0 is straight ahead, left is positive. Some lidars count from -π to π, others from 0 to 2π.

    Returns
    -------
    float | None
        Distance [m]: ``inf`` when nothing is in range, 0.0 when something is closer than the lidar
        can measure (``-inf``). ``None`` when no reading ahead is usable: NaN and finite readings
        outside ``range_min`` … ``range_max`` say nothing (REP-117).
    """
    # TODO(task 3): look at each beam of scan.ranges. Is it ahead? Is its reading usable?
    # Return the smallest of those that are.
    return 0.0


def choose_speed(distance: float | None) -> float:
    """Decision: return the forward speed [m/s] for a distance ahead [m].

    Below 0.5 m: 0.0 m/s. From 0.5 m to below 1.0 m: 0.15 m/s. From 1.0 m on, ``inf`` too: 0.5 m/s.
    ``None``, a robot that cannot see, stands still: 0.0 m/s.
    """
    # TODO(task 4): compare the distance with STOP_DISTANCE and SLOW_DISTANCE.
    return 0.0


class ObstacleAvoidanceAgent(Node):
    """Drives straight ahead, and slows down or stops for what is in front of it."""

    def __init__(self) -> None:
        super().__init__("obstacle_avoidance_agent")
        # TODO(task 1): create a publisher of Twist on /cmd_vel
        # and a subscription to LaserScan on /scan that calls self.scan_callback.
        self.get_logger().info("Obstacle avoidance agent started")

    def scan_callback(self, scan: LaserScan) -> None:
        """Run the loop once: perceive, decide, act. Exactly one Twist for each scan."""
        distance = front_distance(scan)
        speed = choose_speed(distance)
        self.drive(speed)
        if distance is None:
            self.get_logger().warning(
                "No usable reading ahead, velocity: 0.00 m/s", throttle_duration_sec=1.0
            )
        else:
            self.get_logger().info(f"Distance: {distance:.2f} m, velocity: {speed:.2f} m/s")

    def drive(self, speed: float) -> None:
        """Action: publish one Twist with ``linear.x`` = speed [m/s] and every other field 0."""
        # TODO(task 2): fill in a Twist and publish it.

    def stop(self) -> None:
        """Stop the robot; `main` calls this at the end."""
        self.drive(0.0)


def main(args: list[str] | None = None) -> None:
    """Run the agent until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = ObstacleAvoidanceAgent()
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
