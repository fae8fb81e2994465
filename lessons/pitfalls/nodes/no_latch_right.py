"""The node between model and motors that knows the emergency stop."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import Trigger


class StopGate(Node):
    def __init__(self) -> None:
        super().__init__("stop_gate")
        self.pressed = False
        self.stopped = True  # until somebody starts it
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(Twist, "/cmd_vel_raw", self.command_callback, 10)
        self.create_subscription(Bool, "/e_stop", self.e_stop_callback, 10)
        self.create_service(Trigger, "/start", self.start_callback)

    def e_stop_callback(self, button: Bool) -> None:
        self.pressed = button.data
        self.stopped = self.stopped or self.pressed
        self.get_logger().info("stopped" if self.pressed else "released: waits for /start")

    def start_callback(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.stopped = self.pressed
        response.success = not self.stopped
        return response

    def command_callback(self, command: Twist) -> None:
        self.publisher.publish(Twist() if self.stopped else command)


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    rclpy.spin(StopGate())


if __name__ == "__main__":
    main()
