"""An independent client of /detect: asks when the judge says so, and tells it the answers."""

import threading

from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from grader.hosted.fields import MAX_TEXT
from grader.hosted.program import spin
from grader.hosted.questions import Question, ask


class DetectionAsker(Node):  # type: ignore[misc]
    """Asks and tells."""

    def __init__(self) -> None:
        super().__init__("course_detection_asker", enable_rosout=False)
        self.client = self.create_client(Trigger, "/detect")
        threading.Thread(target=self.ask_in_turn, daemon=True).start()

    def ask_in_turn(self) -> None:
        """Ask each time the judge says so; it has not answered when there is no more to ask."""
        while True:
            turn = ask(Question("turn", "/detect")).load
            future = self.client.call_async(Trigger.Request())
            future.add_done_callback(lambda answer, turn=turn: self.tell(turn, answer))

    def tell(self, turn: int, answer: Future) -> None:
        """Tell the judge what came of a request."""
        response = answer.result()
        said = response.message.encode()[:MAX_TEXT]
        ask(Question("answer", "/detect", turn, int(response.success), said))


if __name__ == "__main__":
    spin(DetectionAsker)
