"""What a program in real time tells of itself, while its threads go on."""

import threading
from types import SimpleNamespace
from typing import Any

import pytest

from rclpy_virtual_time.host.frames import EndpointReport
from rclpy_virtual_time.host.real_time import node as live
from rclpy_virtual_time.host.real_time.node import Vitals

PUBLISHER = SimpleNamespace(topic_name="/cmd_vel", get_subscription_count=lambda: 1)
SUBSCRIPTION = SimpleNamespace(topic_name="/scan", get_publisher_count=lambda: 1)


@pytest.fixture
def vitals(monkeypatch: pytest.MonkeyPatch) -> Vitals:
    def report(kind: str, node: object, endpoint: Any) -> EndpointReport:
        return EndpointReport(kind, str(node), endpoint.topic_name, "a/msg/B")

    monkeypatch.setattr(live, "report", report)
    return Vitals()


def topics(pulse: Any) -> list[str]:
    return [end.topic for end in pulse.endpoints]


def test_each_endpoint_is_reported_once(vitals: Vitals) -> None:
    vitals.on_endpoint("publisher", "/n", PUBLISHER)
    vitals.on_endpoint("subscription", "/n", SUBSCRIPTION)
    first, second = vitals.pulse(), vitals.pulse()

    assert topics(first) == ["/cmd_vel", "/scan"]
    assert topics(second) == []
    assert second.connected == {"publisher /cmd_vel": 1, "subscription /scan": 1}


def test_an_endpoint_is_not_lost_when_a_pulse_comes_while_it_is_described(
    vitals: Vitals, monkeypatch: pytest.MonkeyPatch
) -> None:
    describe, told = live.report, []

    def interrupted(kind: str, node: object, endpoint: Any) -> EndpointReport:
        told.extend(topics(vitals.pulse()))  # another thread's, in between
        return describe(kind, node, endpoint)

    monkeypatch.setattr(live, "report", interrupted)
    vitals.on_endpoint("subscription", "/n", SUBSCRIPTION)
    assert [*told, *topics(vitals.pulse())] == ["/scan"]


def test_a_node_that_spins_has_reported_all_of_its_constructor(vitals: Vitals) -> None:
    """The node may make an endpoint and spin while a pulse is made: that pulse says neither."""

    class Slow:
        """A lock after which, once, the node goes on before the pulse does."""

        def __init__(self) -> None:
            self.lock, self.first = threading.Lock(), True

        def __enter__(self) -> None:
            self.lock.acquire()

        def __exit__(self, *_: object) -> None:
            self.lock.release()
            if self.first:
                self.first = False
                vitals.on_endpoint("subscription", "/n", SUBSCRIPTION)
                vitals.wait_begins()

    vitals.on_endpoint("publisher", "/n", PUBLISHER)
    vitals._lock = Slow()  # type: ignore[assignment]
    pulse = vitals.pulse()
    assert (pulse.spinning, topics(pulse)) == (False, ["/cmd_vel"])
    pulse = vitals.pulse()
    assert (pulse.spinning, topics(pulse)) == (True, ["/scan"])
