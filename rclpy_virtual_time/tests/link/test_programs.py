"""Programs in virtual time without a robot: what is given to them, and what is raised of them."""

import struct

import pytest

from rclpy_virtual_time import Delivery, HostForged, Offer
from rclpy_virtual_time.tests.runs import RunNode, end_of, said, times


def test_messages_come_when_they_are_due_in_any_order(run_node: RunNode) -> None:
    data = b"\0\1\0\0" + struct.pack("<I3s", 3, b"hi\0")
    run = run_node(
        """
        rclpy.init(); node = Node('hears'); began = time.monotonic()
        talk = node.create_publisher(String, '/said', 10)
        def hear(message):
            print(message.data, round(time.monotonic() - began, 3))
            talk.publish(message)
        node.create_subscription(String, '/heard', hear, 10)
        rclpy.spin(node)
        """,
        offers=[Offer("/heard", "std_msgs/msg/String", reliable=True)],
        deliveries=[(at, Delivery("/heard", data)) for at in (1_500_000_000, 0, 2**60)],
    )
    assert (end_of(run), said(run), run.now) == ("completed", ["hi 0.0", "hi 1.5"], 2 * 10**9)
    assert times(run, "/said").tolist() == [0.0, 1.5]


def test_what_was_printed_is_noted_on_what_is_raised(run_node: RunNode) -> None:
    lies = "os.write(fd, b'\\xff' * 8)\n    except OSError: pass"
    with pytest.raises(HostForged, match="a frame of") as forged:
        run_node(f"print('begins', flush=True)\nfor fd in range(3, 20):\n    try: {lies}")
    assert forged.value.__notes__ == ["begins"]


def test_a_question_has_nobody_who_answers(run_node: RunNode) -> None:
    with pytest.raises(HostForged, match="a question"):
        run_node("import rclpy_virtual_time as engine\nrclpy.init()\nengine.ask_judge(b'')")
