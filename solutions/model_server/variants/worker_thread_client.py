"""A worker thread asks and waits, with a time limit, on an Event that the executor sets.

file: detection_client.py
field: all
"""

import json
import threading
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import String, UInt32
from std_srvs.srv import Trigger


class Client(Node):
    def __init__(self):
        super().__init__("detection_client")
        self.role = self.declare_parameter("role", "navigation").value
        self.client = self.create_client(Trigger, "/detect")
        self.heartbeat = self.create_publisher(UInt32, f"/{self.role}/heartbeat", 10)
        self.detection = self.create_publisher(String, f"/{self.role}/detection", 10)
        self.count = 0
        self.create_timer(0.1, self.beat)
        threading.Thread(target=self.work, daemon=True).start()

    def beat(self):
        self.count += 1
        self.heartbeat.publish(UInt32(data=self.count))

    def work(self):
        due = time.monotonic()
        while rclpy.ok():
            due += 0.5
            time.sleep(max(0.0, due - time.monotonic()))
            if self.client.service_is_ready():
                self.ask()
            due = max(due, time.monotonic() - 0.499)

    def ask(self):
        answered = threading.Event()
        future = self.client.call_async(Trigger.Request())
        future.add_done_callback(lambda _: answered.set())
        if not answered.wait(1.0):
            self.client.remove_pending_request(future)
            self.get_logger().warning("the server does not answer")
            return
        response = future.result()
        if not response.success:
            return
        try:
            json.loads(response.message)["label"]
        except (ValueError, KeyError, TypeError):
            self.get_logger().error(f"malformed: {response.message[:60]}")
            return
        self.detection.publish(String(data=response.message))


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(Client())


if __name__ == "__main__":
    main()
