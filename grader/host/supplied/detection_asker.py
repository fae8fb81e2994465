"""An independent client of /detect: asks at set times, and publishes what it is told.

The parameter `ask_at` holds the times [s since the scenario's start]. When it asks, the number of
the request goes out on /probe/asked; its answer goes out on /probe/told.
"""

import json
import os

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Empty, String, UInt32
from std_srvs.srv import Trigger


class DetectionAsker(Node):  # type: ignore[misc]
    """Asks and tells."""

    def __init__(self) -> None:
        super().__init__("course_detection_asker", enable_rosout=False)
        times = self.declare_parameter("ask_at", [1.0]).value
        self.asked = self.create_publisher(UInt32, "/probe/asked", 10)
        self.told = self.create_publisher(String, "/probe/told", 10)
        self.client = self.create_client(Trigger, "/detect")
        if "ROS_DOMAIN_ID" in os.environ:  # in real time programs are there before time begins
            self.create_subscription(Empty, "/probe/go", lambda _: self.ask_all(times), 1)
        else:
            self.ask_all(times)

    def ask_all(self, times: list[float]) -> None:
        """Ask at these times [s from now]."""
        for number, time in enumerate(times):
            self.ask_once(number, time)

    def ask_once(self, number: int, time: float) -> None:
        """Ask `time` [s] from now."""

        def timer_callback() -> None:
            timer.cancel()
            self.asked.publish(UInt32(data=number))
            future = self.client.call_async(Trigger.Request())
            future.add_done_callback(lambda answer: self.tell(number, answer))

        timer = self.create_timer(time, timer_callback)

    def tell(self, number: int, answer: Future) -> None:
        """Publish the answer to a request."""
        response = answer.result()
        said = {"type": "answered", "success": response.success, "message": response.message}
        self.told.publish(String(data=json.dumps({"number": number, **said})))


def main(args: list[str] | None = None) -> None:
    """Ask until the trial ends."""
    try:
        rclpy.init(args=args)
        node = DetectionAsker()
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
