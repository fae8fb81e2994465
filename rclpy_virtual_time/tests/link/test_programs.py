"""Programs in virtual time without a robot: what is given to them, and what is raised of them."""

import struct

import pytest

from rclpy_virtual_time import Delivery, HostDied, HostForged, HostHung, Offer
from rclpy_virtual_time.tests.runs import RunNode, end_of, said, times


def test_messages_come_when_they_are_due_in_any_order(run_node: RunNode) -> None:
    data = struct.pack("<4xI3s", 3, b"hi\0")
    data = b"\0\1" + data[2:]
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


def test_a_program_that_sleeps_first_starts_so_much_earlier(run_node: RunNode) -> None:
    run = run_node("time.sleep(0.7); rclpy.init(); print('up'); rclpy.spin(Echo())")
    assert [(line.time, line.text) for line in run.log] == [(0, "up")]
    assert len(times(run, "/cmd_vel")) == 20


LIES = "for fd in range(3, 20):\n    try: os.write(fd, b'\\xff' * 8)\n    except OSError: pass"


@pytest.mark.parametrize(
    ("source", "error", "words"),
    [
        ("os._exit(5)", HostDied, "exit code 5"),
        ("rclpy.init(); Echo()\nwhile True: pass", HostHung, "no answer"),
        (LIES, HostForged, "a frame of"),
    ],
)
def test_what_no_program_does_is_raised(
    run_node: RunNode, source: str, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words) as raised:
        run_node("print('begins', flush=True)\n" + source, limit=3.0 if error is HostHung else 20.0)
    assert raised.value.__notes__[0].splitlines()[-1] == "begins"


def test_a_question_has_nobody_who_answers(run_node: RunNode) -> None:
    with pytest.raises(HostForged, match="a question"):
        run_node("import rclpy_virtual_time as engine\nrclpy.init()\nengine.ask_judge(b'')")
