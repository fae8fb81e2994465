"""As little code as the contract allows.

file: detection_client.py
field: all
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String, UInt32
from std_srvs.srv import Trigger


class DetectionClient(Node):
    def __init__(self):
        super().__init__("detection_client")
        role = self.declare_parameter("role", "navigation").value
        self.count = 0
        self.future = None
        self.asked = None
        self.client = self.create_client(Trigger, "/detect")
        self.heartbeat = self.create_publisher(UInt32, f"/{role}/heartbeat", 10)
        self.detection = self.create_publisher(String, f"/{role}/detection", 10)
        self.create_timer(0.1, self.heartbeat_callback)
        self.create_timer(0.5, self.ask_callback)

    def heartbeat_callback(self):
        self.heartbeat.publish(UInt32(data=self.count))
        self.count += 1

    def ask_callback(self):
        now = self.get_clock().now().nanoseconds / 1e9
        if self.future is not None:
            if now - self.asked < 1.0:
                return
            self.get_logger().warning("no answer, giving up")
            self.client.remove_pending_request(self.future)
            self.future = None
        if not self.client.service_is_ready():
            return
        self.asked = now
        self.future = self.client.call_async(Trigger.Request())
        self.future.add_done_callback(self.answer_callback)

    def answer_callback(self, future):
        self.future = None
        response = future.result()
        if response.success:
            self.detection.publish(String(data=response.message))


def main(args=None):
    rclpy.init(args=args)
    node = DetectionClient()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
