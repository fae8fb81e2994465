"""Driver: decision. How fast does it want to drive, at this distance?

Subscribes  distance  std_msgs/msg/Float64     the nearest thing ahead [m]
Publishes   cmd_vel   geometry_msgs/msg/Twist  the wish: forward speed [m/s], for each distance
Parameters  cruise_speed [m/s], stop_distance [m]
"""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float64


class Driver(Node):
    """Wants to drive at one speed, until something is near."""

    def __init__(self) -> None:
        super().__init__("driver")
        self.cruise_speed: float = self.declare_parameter("cruise_speed", 0.2).value
        self.stop_distance: float = self.declare_parameter("stop_distance", 0.5).value
        self.publisher = self.create_publisher(Twist, "cmd_vel", 10)
        self.create_subscription(Float64, "distance", self.distance_callback, 10)

    def distance_callback(self, distance: Float64) -> None:
        """Decide, and tell: one Twist for each distance."""
        twist = Twist()
        # TODO(task 5): drive at cruise_speed; below stop_distance stand.
        self.publisher.publish(twist)


def main(args: list[str] | None = None) -> None:
    """Decide until Ctrl-C."""
    try:
        rclpy.init(args=args)
        rclpy.spin(Driver())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
