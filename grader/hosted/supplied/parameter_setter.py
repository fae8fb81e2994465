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
from rclpy.task import Future
from std_msgs.msg import String


class ParameterSetter(Node):  # type: ignore[misc]
    """Asks and tells."""

    def __init__(self, node: str, orders: list[str]) -> None:
        super().__init__("course_parameter_setter")
        self.client = AsyncParameterClient(self, node)
        self.answers = self.create_publisher(String, "/course_parameters", 100)
        threading.Thread(target=self.carry_out, args=(orders,), daemon=True).start()

    def carry_out(self, orders: list[str]) -> None:
        """Give each order at its time."""
        begin = time.monotonic()
        for number, order in enumerate(orders):
            at, text = order.split(maxsplit=1)
            time.sleep(max(0.0, begin + float(at) - time.monotonic()))
            self.ask(text).add_done_callback(
                lambda done, number=number, text=text: self.tell(number, text, done.result())
            )

    def ask(self, text: str) -> Future:
        """Ask the node; its answer is to come."""
        words = text.split()
        if text.endswith("?"):
            return self.client.describe_parameters([word[:-1] for word in words])
        pairs = [word.split(":=") for word in words]
        wanted = [ParameterMsg(name=name, value=get_parameter_value(v)) for name, v in pairs]
        client = self.client
        return (client.set_parameters if len(wanted) == 1 else client.set_parameters_atomically)(
            wanted
        )

    def tell(self, number: int, text: str, answer: Any) -> None:
        """Log and publish the node's answer."""
        if hasattr(answer, "descriptors"):
            said = {"described": [_described(each) for each in answer.descriptors]}
        else:
            result = answer.result if hasattr(answer, "result") else answer.results[0]
            said = {"accepted": result.successful, "reason": result.reason}
            word = "accepted" if result.successful else "refused"
            self.get_logger().info(f"{text}: {word} {result.reason}".rstrip())
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
