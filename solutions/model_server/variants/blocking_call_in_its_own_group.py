"""A blocking call with a time limit, in a callback group of its own and with three threads.

file: detection_client.py
field: all
"""

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String, UInt32
from std_srvs.srv import Trigger


class Client(Node):
    def __init__(self):
        super().__init__("detection_client")
        role = self.declare_parameter("role", "navigation").value
        self.beat = 0
        self.client = self.create_client(
            Trigger, "/detect", callback_group=MutuallyExclusiveCallbackGroup()
        )
        self.beats = self.create_publisher(UInt32, f"/{role}/heartbeat", 1)
        self.found = self.create_publisher(String, f"/{role}/detection", 1)
        self.create_timer(0.1, self.live, callback_group=MutuallyExclusiveCallbackGroup())
        self.create_timer(0.5, self.ask, callback_group=MutuallyExclusiveCallbackGroup())

    def live(self):
        self.beats.publish(UInt32(data=self.beat))
        self.beat += 1

    def ask(self):
        if not self.client.service_is_ready():
            return
        try:
            response = self.client.call(Trigger.Request(), timeout_sec=1.0)
        except TimeoutError:  # from ROS 2 Kilted on; Jazzy returns None
            response = None
        if response is None:
            self.get_logger().warning("gave a request up")
        elif response.success:
            self.found.publish(String(data=response.message))


def main(args=None):
    rclpy.init(args=args)
    node = Client()
    executor = MultiThreadedExecutor(3)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
