"""Detection client: asks the detection server twice a second, and never waits for it.

Calls       /detect          std_srvs/srv/Trigger  every 0.5 s
Publishes   /ROLE/detection  std_msgs/msg/String   what the server said, when it had something
            /ROLE/heartbeat  std_msgs/msg/UInt32   1, 2, 3 … every 0.1 s, whatever the server does
Parameter   role             string: navigation, manipulation or logging; one node for each

    python3 detection_client.py --ros-args -r __node:=logging_client -p role:=logging
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import String, UInt32
from std_srvs.srv import Trigger

HEARTBEAT_PERIOD = 0.1  # [s]
ASK_PERIOD = 0.5  # [s]
PATIENCE = 1.0  # [s] a request without an answer is given up after this


class DetectionClient(Node):
    """Two timers: one beats, one asks. No callback ever waits for another one."""

    def __init__(self) -> None:
        super().__init__("detection_client")
        role: str = self.declare_parameter("role", "navigation").value
        self.beats = 0
        self.request: Future | None = None  # its answer is still to come; None: no open request
        self.asked_at = self.get_clock().now()
        self.heartbeat_publisher = self.create_publisher(UInt32, f"/{role}/heartbeat", 10)
        self.detection_publisher = self.create_publisher(String, f"/{role}/detection", 10)
        # TODO(task 5): create a client of the service /detect, of type Trigger, and two timers.
        self.get_logger().info(f"Detection client started, role {role}")

    def heartbeat_callback(self) -> None:
        """Show that this node is alive: count up."""
        # TODO(task 5): count and publish.

    def ask_callback(self) -> None:
        """Ask the server, unless a request is still open; give that one up after 1 s."""
        # TODO(task 6): call_async, and a callback for the answer. Never wait here.
        # TODO(task 7): at most one request at a time; give one up after PATIENCE.

    def answer_callback(self, future: Future) -> None:
        """Publish what the server said, as it said it, if it had something to say."""
        # TODO(task 6): publish the answer's message, if its success is true.


def main(args: list[str] | None = None) -> None:
    """Run the client until Ctrl-C."""
    try:
        rclpy.init(args=args)
        node = DetectionClient()
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
