"""Presses *start*: calls /start, where a node offers it, and logs the answer."""

import threading

from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from grader.hosted.program import spin
from grader.hosted.questions import wait_until


class Starter(Node):  # type: ignore[misc]
    """A person who sees the robot."""

    def __init__(self) -> None:
        super().__init__("course_starter")
        times = self.declare_parameter("press_at", [0.0]).value  # [s]
        self.client = self.create_client(Trigger, "/start")
        threading.Thread(target=self.press, args=(times,), daemon=True).start()

    def press(self, times: list[float]) -> None:
        """Press at each time."""
        for at in times:
            wait_until(at)
            if self.client.service_is_ready():
                self.client.call_async(Trigger.Request()).add_done_callback(self.tell)

    def tell(self, answer: Future) -> None:
        """Log the node's answer."""
        response = answer.result()
        word = "accepted" if response.success else "refused"
        self.get_logger().info(f"start: {word}, {response.message}".rstrip(", "))


if __name__ == "__main__":
    spin(Starter)
