"""The node between model and motors that knows the emergency stop."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from std_msgs.msg import Bool


class StopGate(Node):
    def __init__(self) -> None:
        super().__init__("stop_gate")
        self.stopped = False
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Twist, "/cmd_vel_raw", self.command_callback, 10)
        self.create_subscription(Bool, "/e_stop", self.e_stop_callback, 10)

    def e_stop_callback(self, button: Bool) -> None:
        self.stopped = button.data
        self.get_logger().info("stopped" if self.stopped else "released")

    def command_callback(self, command: Twist) -> None:
        self.publisher.publish(Twist() if self.stopped else command)


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    rclpy.spin(StopGate())


if __name__ == "__main__":
    main()
