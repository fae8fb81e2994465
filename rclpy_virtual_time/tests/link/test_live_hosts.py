"""The processes of a trial in real time, as the judge hears them: stand-ins for what they say."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from rclpy_virtual_time.host.frames import LENGTH as HEAD
from rclpy_virtual_time.host.frames import (
    MAX_CONNECTED,
    MAX_PUBLISHED,
    Delivery,
    EndpointReport,
    HeardNow,
    Published,
    Pulse,
    decode_from_live,
    encode,
)
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.exchange import Flood, HostDied, HostHung
from rclpy_virtual_time.link.live_hosts import MAX_IN_SLOT, LiveHosts

BEGUN = 1_700_000_000_000_000_000  # [ns]
SILENT: Any = SimpleNamespace(next_due=None, due=lambda now: [])


class Radio:
    """A radio that says what it is told to."""

    gone = False

    def __init__(self) -> None:
        self.frames: list[Any] = []
        self.error: Exception | None = None

    def hear(self) -> list[Any]:
        frames, self.frames = self.frames, []
        return frames

    def send(self, frame: Any) -> None:
        if self.error:
            raise self.error


@pytest.fixture
def hosts() -> LiveHosts:
    server: Any = SimpleNamespace()
    hosts = LiveHosts(server, Path(), (), (), 0, SILENT, 20.0)
    hosts.radio = Radio()  # type: ignore[assignment]
    return hosts


def said(time: int, topic: str = "/t", size: int = 1) -> Published:
    return Published(time, topic, "a/msg/B", bytes(size))


def program(spun: int, *topics: str) -> Any:
    pulse = Pulse(spun, 0.0, [], {})
    quiet = SimpleNamespace(note_time=lambda now: None, hear=list, gone=False)
    start = SimpleNamespace(stop=None)
    return SimpleNamespace(pulse=pulse, topics=set(topics), link=quiet, start=start, over=False)


def heard(hosts: LiveHosts, *messages: Published) -> list[Published]:
    hosts.radio.frames = [HeardNow(list(messages))]  # type: ignore[attr-defined]
    hosts.listen(0.0)
    return hosts.take_heard()


def test_a_start_up_ends_when_its_own_program_spins(hosts: LiveHosts) -> None:
    hosts.programs = [program(10, "/quick"), program(30, "/slow")]
    early, late = said(9, "/quick"), said(20, "/quick")
    slow, both = said(20, "/slow"), said(40, "/slow")
    assert heard(hosts, early, late, slow, both) == [early, slow]


def test_since_time_has_begun_everything_counts_that_was_said_then(hosts: LiveHosts) -> None:
    hosts.programs = [program(BEGUN - 10, "/t")]
    hosts.epoch = BEGUN
    before, after, start_up = said(BEGUN - 5), said(BEGUN + 5), said(BEGUN - 20)
    assert heard(hosts, before, after, start_up) == [start_up, after]


@pytest.mark.parametrize("begun", [0, BEGUN])
def test_more_messages_at_a_time_than_a_node_may_say_are_a_flood(
    hosts: LiveHosts, begun: int
) -> None:
    hosts.epoch = begun
    half = [said(BEGUN + 1)] * (MAX_PUBLISHED // 2 + 1)
    heard(hosts, *half)
    hosts.radio.frames = [HeardNow(half), HeardNow(half)]  # type: ignore[attr-defined]
    with pytest.raises(Flood, match="messages"):
        hosts.listen(0.0)


def test_what_is_said_before_time_begins_is_limited_in_all(hosts: LiveHosts) -> None:
    """Nobody takes it before, however long the programs need to meet."""
    with pytest.raises(Flood, match="before it spins"):
        for _ in range(10):
            hosts.radio.frames = [HeardNow([said(1, size=1_000_000)])]  # type: ignore[attr-defined]
            hosts.listen(0.0)


def test_lenient_hosts_note_of_a_loop_without_a_wait_what_a_driver_would_take() -> None:
    server: Any = SimpleNamespace()
    hosts = LiveHosts(server, Path(), (), (), 0, SILENT, 20.0, lenient=True)
    hosts.radio = Radio()  # type: ignore[assignment]
    hosts.epoch = BEGUN
    often = [said(BEGUN + n * 10_000) for n in range(2 * MAX_PUBLISHED)]  # in 80 ms
    assert len(heard(hosts, *often, said(BEGUN, "/other"))) == 8 * MAX_IN_SLOT + 1


@pytest.mark.parametrize("error", [HostDied(), HostHung("stacks")])
def test_a_radio_that_does_not_take_orders_is_no_verdict(
    hosts: LiveHosts, error: Exception
) -> None:
    hosts.radio.error = error  # type: ignore[attr-defined]
    with pytest.raises(EngineError, match="nothing can be said of the node"):
        hosts.transmit([Delivery("/scan", b"")])


def test_a_pulse_has_limits() -> None:
    report = EndpointReport("publisher", "/n", "/t", "a/msg/B")
    fine = Pulse(BEGUN, 0.0, [report], dict.fromkeys(map(str, range(MAX_CONNECTED)), 1))
    assert decode_from_live(encode(fine)[HEAD.size :]) == fine
    for odd in (
        Pulse(BEGUN, 0.0, [], dict.fromkeys(map(str, range(MAX_CONNECTED + 1)), 1)),
        Pulse(-1, 0.0, [], {}),
        Pulse(2**64 - 1, 0.0, [], {}),
        Pulse(BEGUN, 0.0, [report] * 501, {}),
    ):
        with pytest.raises(msgspec.ValidationError):
            decode_from_live(encode(odd)[HEAD.size :])
