"""Hosts that the test plays: what no host can do, and what a judge makes of one that forges."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from node_runs import short

from grader.course.submission import Submission
from grader.recording import Recording
from grader.trial import endings, recorder
from grader.trial.virtual_time import Limits, run_trial
from rclpy_virtual_time.host.frames import (
    MAX_NAME,
    MAX_PUBLISHED,
    Ended,
    EndpointReport,
    Moment,
    Place,
    Published,
    Slept,
    encode,
)
from rclpy_virtual_time.link import pipes
from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.pipes import Pipes
from rclpy_virtual_time.tests.fake_host import FakeHost, frame, settled
from sim.messages import LASER_SCAN, TWIST, twist

SCANS = [13_000_000 + i * 100_000_000 for i in range(10)]  # [ns] when the lidar of `short` sends
FIRST = SCANS[0]
START = settled(endpoints=[EndpointReport("subscription", "/node", "/scan", LASER_SCAN)])
GO = Published(FIRST, "/cmd_vel", TWIST, twist(time=0, linear_x=0.5).data)


class FakeForkServer:
    """Gives out one host that the test plays."""

    def __init__(self, *answers: bytes, hang_up: bool = True) -> None:
        self._answers, self._hang_up = answers, hang_up

    @contextmanager
    def host(self, folder: Path) -> Iterator[Link]:
        with FakeHost(self._answers, hang_up=self._hang_up) as host:
            yield Link(Pipes(host))


@pytest.fixture
def forge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):  # type: ignore[no-untyped-def]
    """Run a trial in which the host gives these answers, one after the other."""
    monkeypatch.setattr(pipes, "STACK_TIME", 0.1)
    monkeypatch.setattr(endings, "GRACE", 0.01)
    file = tmp_path / "node.py"
    file.write_text("pass")

    def run(
        *answers: bytes, hang_up: bool = True, step: float = 20.0, most: int = recorder.MAX_BYTES
    ) -> Recording:
        forkserver = FakeForkServer(*answers, hang_up=hang_up)
        limits = Limits(start=20.0, step=step, total=30.0, published=most)
        return run_trial(Submission(file), short(1.0), forkserver, limits=limits)  # type: ignore[arg-type]

    return run


def test_an_honest_fake_host_completes(forge) -> None:  # type: ignore[no-untyped-def]
    recording = forge(START, *(settled(time) for time in (*SCANS, 10**9)))

    assert recording.outcome.completed
    assert [message.time for message in recording.of("/scan")] == SCANS


RAN = Moment(0, 0, 0, 0, "task", "", "", Place("f", ""), "", [], [], [], 0, "", "", [])
TIMES = {
    "not the start": [settled(1)],
    "back in time": [START, settled(FIRST), settled(0)],
    "standing still": [START, settled(0)],
    "ahead of time": [START, settled(10**9)],
    "the end of time": [START, settled(2**62)],
    "a message from the future": [START, settled(FIRST, published=[
        Published(FIRST + 1, "/cmd_vel", TWIST, b"")])],
    "a message from the past": [START, settled(FIRST), settled(SCANS[1], published=[
        Published(FIRST - 1, "/cmd_vel", TWIST, b"")])],
    "messages in disorder": [START, settled(FIRST, published=[
        GO, Published(FIRST - 1, "/cmd_vel", TWIST, b"")])],
    "an end in the future": [START, encode(Ended(10**9, "returned", "", "", []))],
    "an end in the past": [START, settled(FIRST), encode(Ended(0, "returned", "", "", []))],
    "early for ever": [encode(Slept(10**9))],
    "early in the middle": [START, encode(Slept(10**9))],
    "two answers": [START + settled(FIRST)],
    "a moment that nobody looks into": [START, settled(FIRST, moments=[RAN])],
    "another kind of end": [frame({"type": "ended", "now": 0, "kind": "completed", "text": "",
                                   "detail": "", "published": []})],
}  # fmt: skip


@pytest.mark.parametrize("what", TIMES)
def test_impossible_times_are_forged(forge, what: str) -> None:  # type: ignore[no-untyped-def]
    recording = forge(*TIMES[what], hang_up=False)

    assert recording.outcome.kind == "forged"
    assert "\n" not in recording.outcome.text
    assert recording.duration_s <= 1.0


def test_a_host_that_hangs_up_is_dead(forge) -> None:  # type: ignore[no-untyped-def]
    outcome = forge(START, settled(FIRST)).outcome

    assert (outcome.kind, outcome.text) == ("died", "the node's process ended by itself (signal 9)")


def test_a_host_that_says_nothing_hangs(forge) -> None:  # type: ignore[no-untyped-def]
    outcome = forge(START, hang_up=False, step=0.05).outcome

    assert outcome.kind == "hung"
    assert outcome.detail.startswith("in the start-up\nagent.py, line 7, in on_scan\n\n")


def test_a_forged_flood_is_a_flood(forge) -> None:  # type: ignore[no-untyped-def]
    long = Published(FIRST, "/" * MAX_NAME, "x" * MAX_NAME, b"")
    flood = settled(FIRST, published=[long] * MAX_PUBLISHED)

    assert forge(START, flood, hang_up=False, most=10**6).outcome.kind == "flooded"


def test_endpoints_without_end_are_a_flood(forge) -> None:  # type: ignore[no-untyped-def]
    many = [EndpointReport("client", "/n", "/t", "x/srv/Y")] * 500
    answers = [settled(time, endpoints=many) for time in (0, *SCANS[:2])]

    assert forge(*answers, hang_up=False).outcome.kind == "flooded"


def test_what_is_told_of_a_moment_has_an_end() -> None:
    kept = recorder.Recorder(["agent.py"], looks=[0])
    kept.look([replace(RAN, place=Place(f"f{i}", "")) for i in range(1000)])
    assert len(kept._moments) == Moment.FUNCTIONS


ODD = ["", "cmd_vel", "/\x00", "/a\nb", "/[bold]x[/]", "/\x1b[31m", "/ü" * 100, "/cmd_vel\u202e"]


@pytest.mark.parametrize("name", ODD)
def test_odd_names_are_just_names(forge, name: str) -> None:  # type: ignore[no-untyped-def]
    odd = Published(FIRST, name, name, b"\xff" * 52)
    recording = forge(START, settled(FIRST, published=[odd]))

    assert [(m.topic, m.type) for m in recording.published] == [(name, name)]
    assert recording.outcome.kind == "died"


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\xff" * 52, b"\0\1\0\0" + b"\xff" * 48])
def test_broken_commands_do_not_move_the_robot(forge, data: bytes) -> None:  # type: ignore[no-untyped-def]
    broken = Published(FIRST, "/cmd_vel", TWIST, data)
    answers = [START, settled(FIRST, published=[broken])]
    recording = forge(*answers, *(settled(time) for time in (*SCANS[1:], 10**9)))

    assert recording.outcome.completed
    assert np.ptp(recording.truth.x) == pytest.approx(0.0, abs=1e-9)
