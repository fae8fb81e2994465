"""The timer's callback is a coroutine that awaits the answer; the second tick after gives it up.

file: detection_client.py
field: all
"""

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String, UInt32
from std_srvs.srv import Trigger


class Client(Node):
    def __init__(self):
        super().__init__("detection_client")
        role = self.declare_parameter("role", "navigation").value
        group = ReentrantCallbackGroup()
        self.client = self.create_client(Trigger, "/detect", callback_group=group)
        self.heartbeat = self.create_publisher(UInt32, f"/{role}/heartbeat", 10)
        self.detection = self.create_publisher(String, f"/{role}/detection", 10)
        self.beats, self.pending, self.ticks = 0, None, 0
        self.create_timer(0.1, self.beat)
        self.create_timer(0.5, self.ask, callback_group=group)

    def beat(self):
        self.beats += 1
        self.heartbeat.publish(UInt32(data=self.beats))

    async def ask(self):
        if self.pending is not None:
            self.ticks += 1
            if self.ticks < 2:
                return
            self.get_logger().warning("two ticks without an answer")
            self.client.remove_pending_request(self.pending)
            self.pending.set_result(None)
            self.pending = None
        if not self.client.service_is_ready():
            return
        self.ticks = 0
        self.pending = future = self.client.call_async(Trigger.Request())
        answer = await future
        if answer is None:
            return
        self.pending = None
        if answer.success:
            self.detection.publish(String(data=answer.message))


def main(args=None):
    rclpy.init(args=args)
    node = Client()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
