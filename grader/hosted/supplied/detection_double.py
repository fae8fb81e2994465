"""A stand-in for the student's detection server: the judge answers, late, wrong or never, by plan.

It carries each request to the judge, who has the plan (`grader/models/partners.py`).
"""

import threading

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from grader.hosted.program import spin
from grader.hosted.questions import Question, ask


class DetectionDouble(Node):  # type: ignore[misc]
    """Answers /detect as the judge does, any number of requests at a time."""

    def __init__(self) -> None:
        super().__init__("course_detection_double", enable_rosout=False)
        group = ReentrantCallbackGroup()
        self.create_service(Trigger, "/detect", self.detect_callback, callback_group=group)

    async def detect_callback(
        self, _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        """Answer one request, or never."""
        answer = Future()
        threading.Thread(target=self.carry, args=(answer,), daemon=True).start()
        told = await answer
        response.success = not told.problem
        response.message = told.problem or told.labels[0]
        return response

    def carry(self, answer: Future) -> None:
        """Wait for the judge's answer to a request."""
        answer.set_result(ask(Question("request", "/detect")))
        self.executor.wake()


if __name__ == "__main__":
    spin(DetectionDouble)
