"""One timer of 0.1 s counts ticks, polls the future, and asks whether or not there is a server.

file: detection_client.py
field: all
"""

import rclpy
from rclpy.node import Node
from std_msgs.msg import String, UInt32
from std_srvs.srv import Trigger


class Client(Node):
    def __init__(self):
        super().__init__("detection_client")
        self.declare_parameter("role", "navigation")
        role = self.get_parameter("role").get_parameter_value().string_value
        self.tick = 0
        self.asked_tick = 0
        self.future = None
        self.client = self.create_client(Trigger, "/detect")
        self.heartbeat_pub = self.create_publisher(UInt32, "/" + role + "/heartbeat", 10)
        self.detection_pub = self.create_publisher(String, "/" + role + "/detection", 10)
        self.timer = self.create_timer(0.1, self.on_tick)

    def on_tick(self):
        msg = UInt32()
        msg.data = self.tick
        self.heartbeat_pub.publish(msg)
        if self.future is not None and self.future.done():
            response = self.future.result()
            self.future = None
            if response.success:
                out = String()
                out.data = response.message
                self.detection_pub.publish(out)
        if self.future is not None and self.tick - self.asked_tick >= 12:
            self.get_logger().warning("no answer for 1.2 s")
            self.client.remove_pending_request(self.future)
            self.future = None
        if self.future is None and self.tick - self.asked_tick >= 5:
            self.future = self.client.call_async(Trigger.Request())
            self.asked_tick = self.tick
        self.tick += 1


def main(args=None):
    rclpy.init(args=args)
    node = Client()
    rclpy.spin(node)


if __name__ == "__main__":
    main()
