"""Each operator of a wrapper, on a short run of messages or numbers."""

from __future__ import annotations

import inspect
import math
from types import SimpleNamespace
from typing import Any

import pytest

from grader.authoring.mutate import hooks, operators, wrappers
from grader.authoring.mutate.wrappers import HEARD, ON_MESSAGES, ON_NUMBERS, ON_READINGS, STAMPED

PERIOD = 0.1  # [s] between two messages


def op(name: str, amount: float = 0.0) -> operators.Operator:
    return operators.Operator(amount, wrappers.changes()[name])


def passed(operator: Any, count: int = 6) -> list[list[int]]:
    """Return what comes out for each of the messages 1, 2, 3 …"""
    return [operator(i, PERIOD * i) for i in range(1, count + 1)]


@pytest.mark.parametrize(
    ("operator", "comes"),
    [
        (op("Late", 2), [[], [], [1], [2], [3], [4]]),
        (op("OneIn", 3), [[1], [], [], [4], [], []]),
        (op("DropsOneIn", 3), [[1], [2], [], [4], [5], []]),
        (op("OldOneIn", 3), [[1], [2], [2], [4], [5], [5]]),
        (op("Holds", 0.25), [[1], [1], [1], [4], [4], [4]]),
        (op("AtMostEvery", 0.25), [[1], [], [], [4], [], []]),
        (op("IgnoresFirst", 2), [[], [], [3], [4], [5], [6]]),
        (op("IgnoresAfter", 2), [[1], [2], [], [], [], []]),
        (op("DeafAfter", 0.25), [[1], [2], [3], [], [], []]),
        (op("Latches"), [[1]] * 6),
        (op("Twice"), [[i, i] for i in range(1, 7)]),
        (op("Reorders"), [[], [2, 1], [], [4, 3], [], [6, 5]]),
        (op("Expires", 1.0), [[i] for i in range(1, 7)]),
    ],
    ids=lambda value: getattr(getattr(value, "change", None), "__name__", ""),
)
def test_messages(operator: Any, comes: list[list[int]]) -> None:
    assert passed(operator) == comes


def test_messages_with_old_stamps_are_dropped() -> None:
    operator, came = op("OnlyNewer"), []
    for second in (5, 6, 6, 4, 7):
        stamp = SimpleNamespace(sec=second, nanosec=0)
        came += operator(SimpleNamespace(header=SimpleNamespace(stamp=stamp)), 0.0)
    assert [message.header.stamp.sec for message in came] == [5, 6, 7]


@pytest.mark.parametrize(
    ("operator", "numbers", "become"),
    [
        (op("Times", -2.0), [1.0, -0.5], [-2.0, 1.0]),
        (op("Plus", 0.5), [1.0, math.inf], [1.5, math.inf]),
        (op("Clips", 0.5), [0.2, 2.0, -2.0, math.inf], [0.2, 0.5, -0.5, 0.5]),
        (op("NanIs", 0.0), [math.nan, 1.0], [0.0, 1.0]),
        (op("Quantises", 0.25), [0.3, 0.4, -0.3, math.inf], [0.25, 0.5, -0.25, math.inf]),
        (op("DeadBand", 0.1), [0.05, -0.05, 0.2], [0.0, 0.0, 0.2]),
        (op("Sticks", 0.1), [1.0, 1.05, 1.2, 1.15], [1.0, 1.0, 1.2, 1.2]),
        (op("LowPass", 0.5), [0.0, 1.0, 1.0], [0.0, 0.5, 0.75]),
        (op("LowPass", 0.5), [math.inf, 1.0, 2.0], [math.inf, 1.0, 1.5]),
        (op("FallsAtMost", 0.25), [1.0, 0.0, 0.0, 1.0], [1.0, 0.75, 0.5, 1.0]),
        (op("RisesAtMost", 0.25), [0.0, 1.0, 1.0, 0.0], [0.0, 0.25, 0.5, 0.0]),
        (op("LeastOf", 2), [3.0, 1.0, 2.0, 5.0], [3.0, 1.0, 1.0, 2.0]),
        (op("ZeroFor", 0.25), [0.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]),
        (op("NotZeroFor", 0.25), [1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.0]),
    ],
    ids=lambda value: getattr(getattr(value, "change", None), "__name__", ""),
)
def test_numbers(operator: Any, numbers: list[float], become: list[float]) -> None:
    came = [operator(number, PERIOD * i) for i, number in enumerate(numbers)]
    assert came == pytest.approx(become)


def test_every_operator_is_tried_and_tested() -> None:
    used = {*ON_MESSAGES, *HEARD, *STAMPED, *ON_NUMBERS, *ON_READINGS}
    assert set(wrappers.changes()) == used
    source = inspect.getsource(inspect.getmodule(test_numbers) or wrappers)
    assert [name for name in used if f'op("{name}"' not in source] == []


# --- hooks ----------------------------------------------------------------------------------------


class FakeNode:
    """As much of rclpy's Node as a hook touches."""

    def __init__(self) -> None:
        self.callbacks: dict[str, Any] = {}
        self.said: list[Any] = []
        self.timers: list[tuple[float, Any]] = []

    def create_subscription(self, kind: Any, name: str, callback: Any, qos: int) -> None:
        self.callbacks[name] = callback

    def create_publisher(self, kind: Any, name: str, qos: int) -> Any:
        return SimpleNamespace(publish=self.said.append)

    def create_timer(self, period: float, callback: Any) -> Any:
        self.timers.append((period, callback))
        return SimpleNamespace(reset=lambda: None, cancel=lambda: None)

    def get_clock(self) -> Any:
        return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=0))


def node_class() -> type[FakeNode]:
    return type("Node", (FakeNode,), {})


def test_a_change_of_what_is_heard_is_for_its_topic_only() -> None:
    node = node_class()
    hooks.hears(node, "/scan", op("Twice"))
    one, heard = node(), []
    for name in ("scan", "/odom"):
        one.create_subscription(object, name, heard.append, 10)
        one.callbacks[name](name)
    assert heard == ["scan", "scan", "/odom"]


def test_what_expires_is_followed_by_something_empty() -> None:
    node = node_class()
    hooks.hears(node, "/e_stop", op("Expires", 2.0))
    one, heard = node(), []
    one.create_subscription(dict, "/e_stop", heard.append, 10)
    one.callbacks["/e_stop"]("pressed")
    ((period, callback),) = one.timers
    callback()
    assert (period, heard) == (2.0, ["pressed", {}])


def test_a_change_of_what_is_said() -> None:
    node = node_class()
    hooks.says(node, "/cmd_vel", hooks.at("linear.x", lambda: op("Times", 2.0)))
    one = node()
    twist = SimpleNamespace(linear=SimpleNamespace(x=0.25))
    one.create_publisher(object, "/cmd_vel", 10).publish(twist)
    one.create_publisher(object, "/other", 10).publish("as it is")
    assert one.said[0].linear.x == 0.5
    assert (one.said[1], twist.linear.x) == ("as it is", 0.25)


def test_each_number_of_a_list_has_an_operator_of_its_own() -> None:
    change = hooks.at("ranges", lambda: op("LeastOf", 2))
    scans = [SimpleNamespace(ranges=ranges) for ranges in ([1.0, 4.0], [2.0, 3.0])]
    assert [scan.ranges for s in scans for scan in change(s, 0.0)] == [[1.0, 4.0], [1.0, 3.0]]
