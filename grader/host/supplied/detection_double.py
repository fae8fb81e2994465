"""A stand-in for the student's detection server: its answers are late, wrong or missing, by plan.

The parameter `answers` is the plan, one word for each request, the last for all that follow: a kind
of answer, then `@` and its delay [s] if there is one (`fine@0.3`). What came and what was answered
goes out on /probe/served, for the judge.
"""

import json
import math

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

MALFORMED = {  # messages that come with success = true, though they are not what was agreed on
    "empty": "",
    "no_json": "box, 90 %",
    "half": '{"label": "box", "confid',
    "list": "[1, 2, 3]",
    "number": "42",
    "null": "null",
    "no_keys": "{}",
    "types": '{"label": 7, "confidence": "high", "stamp": null}',
    "nan": '{"label": "box", "confidence": NaN, "stamp": 1e999}',
    "long": json.dumps({"label": "box " * 5_000}),
    "unicode": '{"label": "Kiste \N{PACKAGE}", "confidence": "½"}',
}

# As JSON may be spelt, with room around it and more keys than those of the contract; who writes it
# anew, strips or shortens it spells it in another way.
SAME = (
    ' {"stamp": 1700000000.250, "label":"Kiste \N{PACKAGE}",  "confidence": 0.50, "notes": "'
    + "seen before; " * 20
    + '"}\n'
)


class DetectionDouble(Node):  # type: ignore[misc]
    """Answers /detect as planned, any number of requests at a time."""

    def __init__(self) -> None:
        super().__init__("course_detection_double", enable_rosout=False)
        plan = self.declare_parameter("answers", "fine").value
        self.plan = [(kind, delay) for kind, _, delay in (w.partition("@") for w in plan.split())]
        self.count = 0
        self.life = self.get_clock().now().nanoseconds  # a new server counts anew
        self.group = ReentrantCallbackGroup()
        self.served = self.create_publisher(String, "/probe/served", 100)
        self.opening = self.create_timer(0.02, self.open)
        self.open()

    def open(self) -> None:
        """Begin to serve as soon as the judge can hear of it; in real time that takes a moment."""
        if self.served.get_subscription_count():
            self.opening.cancel()
            self.create_service(Trigger, "/detect", self.detect_callback, callback_group=self.group)

    async def detect_callback(
        self, _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        """Answer one request, or never."""
        number = self.count
        self.count += 1
        kind, delay = self.plan[min(number, len(self.plan) - 1)]
        self.note(number, type="asked", kind=kind)
        if kind == "never":
            await Future()
        if delay:
            await self.pause(float(delay))
        response.success = kind not in ("refused", "unsure")
        response.message = self.message(kind, number)
        self.note(number, type="answered", success=response.success, message=response.message)
        return response

    def note(self, number: int, **what: object) -> None:
        """Send the judge a note about a request."""
        self.served.publish(String(data=json.dumps({"life": self.life, "number": number, **what})))

    def message(self, kind: str, number: int) -> str:
        """Return an answer's text; no two good ones are the same, but those of the kind `same`."""
        if kind == "refused":
            return "there is no scan yet"
        if kind == "same":
            return SAME
        if kind not in ("fine", "unsure"):  # who is unsure says what it would be, and no success
            return MALFORMED[kind]
        stamp = self.get_clock().now().nanoseconds / 1e9
        confidence = 0.05 + 0.9 * math.sin(number) ** 2
        return json.dumps({"label": f"box {number}", "confidence": confidence, "stamp": stamp})

    async def pause(self, seconds: float) -> None:
        """Let time pass without keeping other requests waiting."""
        over = Future()
        timer = self.create_timer(seconds, lambda: over.set_result(None), callback_group=self.group)
        await over
        self.destroy_timer(timer)


def main(args: list[str] | None = None) -> None:
    """Serve until the trial ends."""
    try:
        rclpy.init(args=args)
        node = DetectionDouble()
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
