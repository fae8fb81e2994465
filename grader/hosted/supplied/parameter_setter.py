"""Sets a node's parameters while it runs, as `ros2 param set` does, and tells what it answered.

Arguments: the node's full name, then orders: `1.06 speed:=0.2` at 1.06 s; `near:=1.0 far:=2.0` are
set together, all or none, `near:=1.0, far:=2.0` in one request, each by itself; `0.5 speed? range?`
asks for the descriptors, and sets parameters of these names of its own: `/parameter_events` then
tells of two nodes. `grader.checks.parameters` reads what is published.
"""

import json
import sys
import threading
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterType
from rclpy.node import Node
from rclpy.parameter import Parameter, get_parameter_value
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future
from std_msgs.msg import String

from grader.hosted.program import spin
from grader.hosted.questions import wait_until


class ParameterSetter(Node):  # type: ignore[misc]
    """Asks and tells."""

    def __init__(self, node: str, orders: list[str]) -> None:
        super().__init__("course_parameter_setter")
        self.client = AsyncParameterClient(self, node)
        self.answers = self.create_publisher(String, "/course_parameters", 100)
        threading.Thread(target=self.carry_out, args=(orders,), daemon=True).start()

    def carry_out(self, orders: list[str]) -> None:
        """Give each order at its time."""
        number = 0
        for order in orders:
            at, text = order.split(maxsplit=1)
            wait_until(float(at))
            self.ask(text).add_done_callback(
                lambda done, number=number, text=text: self.tell(number, text, done.result())
            )
            number += len(text.split(", "))

    def ask(self, text: str) -> Future:
        """Ask the node; its answer is to come."""
        words = text.replace(", ", " ").split()
        if text.endswith("?"):
            names = [word[:-1] for word in words]
            self.declare_parameters("", [(name, 0.0) for name in names])
            self.set_parameters([Parameter(name, value=1.0) for name in names])
            return self.client.describe_parameters(names)
        pairs = [word.split(":=") for word in words]
        wanted = [ParameterMsg(name=name, value=get_parameter_value(v)) for name, v in pairs]
        if len(text.split(", ")) == len(wanted):
            return self.client.set_parameters(wanted)
        return self.client.set_parameters_atomically(wanted)

    def tell(self, number: int, text: str, answer: Any) -> None:
        """Log and publish the node's answer: of several values set each by itself, each answer."""
        if hasattr(answer, "descriptors"):
            said = {"order": number, "described": [_described(each) for each in answer.descriptors]}
            self.client.list_parameters().add_done_callback(
                lambda done: self.publish(said | {"there": done.result().result.names})
            )
            return
        results = [answer.result] if hasattr(answer, "result") else answer.results
        for i, (part, result) in enumerate(zip(text.split(", "), results, strict=False)):
            word = "accepted" if result.successful else "refused"
            self.get_logger().info(f"{part}: {word} {result.reason}".rstrip())
            said = {"accepted": result.successful, "reason": result.reason}
            self.publish({"order": number + i, **said})

    def publish(self, said: dict[str, Any]) -> None:
        """Publish a word of the node's."""
        self.answers.publish(String(data=json.dumps(said)))


def _described(descriptor: Any) -> dict[str, Any]:
    double = descriptor.type == ParameterType.PARAMETER_DOUBLE
    ranges = descriptor.floating_point_range, descriptor.integer_range
    counts, other = ranges if double else ranges[::-1]  # a range of another type is ignored
    limits = [float(end) for span in counts for end in (span.from_value, span.to_value)]
    about = {"name": descriptor.name, "type": descriptor.type, "limits": limits}
    return about | {"description": descriptor.description, "ignored": bool(other)}


if __name__ == "__main__":
    spin(lambda: ParameterSetter(sys.argv[1], sys.argv[2:]))
