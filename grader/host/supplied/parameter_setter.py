"""Sets a node's parameters while it runs, as `ros2 param set` does, and tells what it answered.

Arguments: the node's full name, then orders: `1.06 speed:=0.2` at 1.06 s; several assignments are
set together, all or none; `0.5 speed? range?` asks for the descriptors. `grader.checks.parameters`
reads what is published.
"""

import json
import sys
import threading
import time
from typing import Any

import rclpy
from rcl_interfaces.msg import Parameter as ParameterMsg
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import get_parameter_value
from rclpy.parameter_client import AsyncParameterClient
from std_msgs.msg import String


class ParameterSetter(Node):  # type: ignore[misc]
    """Asks and tells."""

    def __init__(self, node: str, orders: list[str]) -> None:
        super().__init__("course_parameter_setter", enable_rosout=False)
        self.client = AsyncParameterClient(self, node)
        self.answers = self.create_publisher(String, "/course_parameters", 100)
        threading.Thread(target=self.carry_out, args=(orders,), daemon=True).start()

    def carry_out(self, orders: list[str]) -> None:
        """Give each order at its time."""
        begin = time.monotonic()
        for number, order in enumerate(orders):
            at, *words = order.split()
            time.sleep(max(0.0, begin + float(at) - time.monotonic()))
            if words[0].endswith("?"):
                future = self.client.describe_parameters([word[:-1] for word in words])
            else:
                pairs = [word.split(":=") for word in words]
                wanted = [ParameterMsg(name=n, value=get_parameter_value(text)) for n, text in pairs]
                together = len(wanted) > 1
                ask = self.client.set_parameters_atomically if together else self.client.set_parameters
                future = ask(wanted)
            future.add_done_callback(lambda done, number=number: self.tell(number, done.result()))

    def tell(self, number: int, answer: Any) -> None:
        """Publish what the node answered to an order."""
        if hasattr(answer, "descriptors"):
            said = {"described": [_described(each) for each in answer.descriptors]}
        else:
            result = answer.result if hasattr(answer, "result") else answer.results[0]
            said = {"accepted": result.successful, "reason": result.reason}
        self.answers.publish(String(data=json.dumps({"order": number, **said})))


def _described(descriptor: Any) -> dict[str, Any]:
    spans = [*descriptor.floating_point_range, *descriptor.integer_range]
    limits = [float(end) for span in spans for end in (span.from_value, span.to_value)]
    about = {"name": descriptor.name, "type": descriptor.type, "limits": limits}
    return about | {"description": descriptor.description}


def main() -> None:
    """Set until the trial ends."""
    try:
        rclpy.init()
        rclpy.spin(ParameterSetter(sys.argv[1], sys.argv[2:]))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
