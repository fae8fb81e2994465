"""Guard: the last node before the motors. It passes on what is safe, and stops when nobody asks.

Subscribes  cmd_vel_raw  geometry_msgs/msg/Twist  what another node wants
Publishes   cmd_vel      geometry_msgs/msg/Twist  what the robot gets, 20 times a second
Parameter   max_speed    [m/s]
"""

import math
import signal

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

PATIENCE = 0.5  # [s] an older wish says nothing about now


class Guard(Node):
    """Trusts nobody: neither that a wish is sane, nor that the next one comes."""

    def __init__(self) -> None:
        super().__init__("guard")
        self.max_speed: float = self.declare_parameter("max_speed", 0.2).value
        self.wish = Twist()
        self.heard_at = self.get_clock().now()
        self.publisher = self.create_publisher(Twist, "cmd_vel", 10)
        self.create_subscription(Twist, "cmd_vel_raw", self.wish_callback, 10)
        self.create_timer(0.05, self.guard)

    def wish_callback(self, wish: Twist) -> None:
        """Remember the newest wish, and when it came."""
        self.wish, self.heard_at = wish, self.get_clock().now()

    def guard(self) -> None:
        """Publish what is safe of the wish: `linear.x`, and 0 in every other field."""
        twist = Twist()
        # TODO(task 6): the wish, from 0 to max_speed; 0 if it is no number, or too old.
        self.publisher.publish(twist)


def main(args: list[str] | None = None) -> None:
    """Guard until Ctrl-C or SIGTERM, then stop the robot."""
    # NO: rclpy's own handlers would shut ROS down before the robot can be stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as Ctrl-C does
    node = Guard()
    try:
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=1.0)  # a signal takes effect between two waits
    except KeyboardInterrupt:
        pass
    finally:
        node.publisher.publish(Twist())
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
