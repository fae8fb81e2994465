"""The judge's end of the link, against hosts that say whatever they like."""

import os
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain, repeat

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rclpy_virtual_time.host.frames import (
    LENGTH,
    MARK,
    MAX_FRAME,
    Delivery,
    ProgramStart,
    Published,
    Run,
    Settled,
    Start,
    encode,
)
from rclpy_virtual_time.link import pipes
from rclpy_virtual_time.link.exchange import MAX_REASON, HostDied, HostForged, HostHung
from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.output import MAX_LINES, MAX_OUTPUT, Output
from rclpy_virtual_time.link.pipes import Pipes
from rclpy_virtual_time.tests.fake_host import FakeHost, frame, settled, talking, write_all

START = Start(programs=(ProgramStart("agent.py"),), epoch=0, seed=1, offers=())
LIMIT = 20.0  # [s] for answers that come
SOON = 0.05  # [s] for answers that don't


@pytest.fixture(autouse=True)
def no_patience_for_stacks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipes, "STACK_TIME", 0.1)


@contextmanager
def linked(
    *answers: bytes, hang_up: bool = True, deaf: bool = False
) -> Iterator[tuple[Link, FakeHost]]:
    with FakeHost(answers, hang_up=hang_up, deaf=deaf) as host:
        yield Link(Pipes(host)), host


def test_an_answer_arrives_whole() -> None:
    message = Published(5, "/cmd_vel", "geometry_msgs/msg/Twist", bytes(range(256)) * 4_000)
    with linked(settled(), settled(9, published=[message])) as (link, _):
        first, _ = link.run(START, LIMIT)
        second, cost = link.run(Run(9, (Delivery("/scan", bytes(300_000)),)), LIMIT)

    assert first == Settled(0, True, False, [])
    assert isinstance(second, Settled)
    assert second.published == [message]
    assert cost.wall > 0


FORGERIES = {  # tests/attacks/test_fuzz.py has more of what a decoder refuses
    "an oversized length": LENGTH.pack(MAX_FRAME + 1),
    "the largest length": b"\xff\xff\xff\xff",
    "an empty frame": frame(b""),
    "deep nesting": frame(b"\x91" * 1_000_000),
    "an array of four billion": frame(b"\x82\xa4type\xa7settled\xa9published\xdd\xff\xff\xff\xff"),
    "a text of four gigabytes": frame(b"\x81\xa4type\xdb\xff\xff\xff\xff"),
    "a megabyte of kind": frame({"type": "A" * 1_000_000}),
    "trailing bytes": frame(settled()[LENGTH.size :] + b"\0"),
    "the judge's own frame": encode(START),
}


@pytest.mark.parametrize("what", FORGERIES)
def test_forgeries_are_refused_in_a_line_and_do_not_fill_the_memory(what: str) -> None:
    with linked(FORGERIES[what], hang_up=False) as (link, _):
        tracemalloc.start()
        with pytest.raises(HostForged) as caught:
            link.run(START, LIMIT)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()

    assert peak < 16 * 1024 * 1024
    assert len(str(caught.value)) <= MAX_REASON


def test_a_stream_without_end_is_not_collected() -> None:
    """The judge reads a frame at most, however much is there to be read."""
    with linked(settled(), hang_up=False) as (link, host):
        link.run(START, LIMIT)
        with talking(host.their_out, bytes(65536)):
            with pytest.raises(HostForged):
                link.run(Run(1), LIMIT)
            assert len(link._host._buffer) < 2 * pipes.CHUNK


@pytest.mark.parametrize("size", [1, LENGTH.size, LENGTH.size + 1, -1])
def test_a_truncated_frame_is_a_death(size: int) -> None:
    with linked(settled()[:size]) as (link, _), pytest.raises(HostDied):
        link.run(START, LIMIT)


@pytest.mark.parametrize("size", [0, 1, LENGTH.size, -1])
def test_half_an_answer_is_waited_for_until_the_limit(size: int) -> None:
    with linked(settled()[:size], hang_up=False) as (link, _), pytest.raises(HostHung) as caught:
        link.run(START, SOON)

    assert caught.value.stacks == '  File "agent.py", line 7 in on_scan'


@pytest.mark.parametrize(
    ("ready", "used"),
    [((True, True, True), (0.0,)), ((False,), (0.0, 0.1 * SOON, 0.2 * SOON, 0.3 * SOON))],
    ids=["a busy machine keeps it waiting", "it gets on, though it is seen waiting"],
)
def test_a_host_that_answers_late_has_not_hung(
    ready: tuple[bool, ...], used: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The answer comes before the last of what is seen."""

    def seen(host: FakeHost, *before: float, last: float) -> Iterator[float]:
        yield from before
        if before:
            write_all(host.their_out, settled())
        yield from repeat(last)

    monkeypatch.setattr(pipes, "STARVED", 1e6)
    with linked(hang_up=False) as (link, host):
        host.ready = map(bool, seen(host, *ready[:-1], last=ready[-1]))
        times = seen(host, *used[:-1], last=used[-1])
        monkeypatch.setattr(Pipes, "cpu", lambda _: next(times))
        answer, _ = link.run(START, SOON)

    assert isinstance(answer, Settled)


COMPUTES, UNKNOWN = chain([0.0, 0.5 * SOON], repeat(SOON)), repeat(float("nan"))


@pytest.mark.parametrize(("used", "starved"), [(COMPUTES, 1e6), (UNKNOWN, pipes.STARVED)])
def test_nobody_is_waited_for_for_ever(
    used: Iterator[float], starved: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipes, "STARVED", starved)
    monkeypatch.setattr(Pipes, "cpu", lambda _: next(used))
    with linked(hang_up=False) as (link, host), pytest.raises(HostHung):
        host.ready = repeat(True)
        link.run(START, SOON)


def test_an_answer_before_the_question_is_forged() -> None:
    with linked(settled() + settled(9), hang_up=False) as (link, _):
        link.run(START, LIMIT)
        with pytest.raises(HostForged, match="before the question"):
            link.run(Run(9), LIMIT)


def test_a_host_that_does_not_read_can_not_block_the_judge() -> None:
    with linked(hang_up=False) as (link, _), pytest.raises(HostHung):
        link.run(Run(1, (Delivery("/scan", bytes(1_000_000)),)), SOON)


def test_a_host_that_closes_its_pipe_in_the_middle_of_a_frame_is_a_death() -> None:
    with linked(deaf=True, hang_up=False) as (link, host):
        os.close(host.their_in)
        host.their_in = -1
        with pytest.raises(HostDied):
            link.run(Run(1, (Delivery("/scan", bytes(1_000_000)),)), LIMIT)


@pytest.mark.parametrize("stream", ["their_stdout", "their_stderr"])
def test_endless_output_does_not_keep_the_judge(stream: str) -> None:
    with (
        linked(hang_up=False) as (link, host),
        talking(getattr(host, stream), b"x" * 65535 + b"\n"),
    ):
        with pytest.raises(HostHung):
            link.run(START, SOON)
        link.log()

    assert len(link.stdout.lines) + len(link.stderr.lines) < MAX_LINES


def test_closed_output_pipes_do_not_matter() -> None:
    with linked(settled(), settled(1)) as (link, host):
        for name in ("their_stdout", "their_stderr"):
            os.write(getattr(host, name), b"last words")
            os.close(getattr(host, name))
            setattr(host, name, -1)
        link.run(START, LIMIT)
        link.run(Run(1), LIMIT)

        assert [line.text for line in link.log()] == ["last words"] * 2


def test_the_log_is_in_order_of_time() -> None:
    with linked(settled(), settled(30)) as (link, host):
        link.run(START, LIMIT)
        link.run(Run(30), LIMIT)
        os.write(host.their_stdout, f"a\n{MARK}20\nd\n".encode())
        os.write(host.their_stderr, f"b\n{MARK}10\nc\n".encode())

        told = [f"{line.time} {line.text}" for line in link.log()]
        assert told == ["0 a", "0 b", "10 c", "20 d"]


# --- output --------------------------------------------------------------------------------------


def said(*pieces: bytes, limit: int = 10**12) -> list[tuple[int, str, str]]:
    output = Output("stdout", limit=limit)
    for piece in pieces:
        output.feed(piece)
    output.finish()
    return [(line.time, line.level, line.text) for line in output.lines]


LINES: dict[bytes, list[tuple[int, str, str]]] = {
    f"one\n{MARK}5\ntwo\n{MARK}7\n".encode(): [(0, "stdout", "one"), (5, "stdout", "two")],
    f"no newline{MARK}5\nlater".encode(): [(0, "stdout", "no newline"), (5, "stdout", "later")],
    f"grüß\n{MARK}5\n[WARN] [a.node]: ärger: [x]\n".encode(): [
        (0, "stdout", "grüß"),
        (5, "warn", "ärger: [x]"),
    ],
    b"[FATAL] [n]: x\n[INFO] no\n[NOTE] [n]: x\n\n": [
        (0, "fatal", "x"),
        (0, "stdout", "[INFO] no"),
        (0, "stdout", "[NOTE] [n]: x"),
        (0, "stdout", ""),
    ],
    b"\x1e\n\x1ex\n": [(0, "stdout", "\x1e"), (0, "stdout", "\x1ex")],
    b"\xff\xfe caf\xe9\n": [(0, "stdout", "\ufffd\ufffd caf\ufffd")],
    f"{MARK}50\na\n{MARK}40\nb\n".encode(): [
        (50, "stdout", "a"),
        (50, "stdout", f"{MARK}40"),  # time does not go back
        (50, "stdout", "b"),
    ],
    b"x" * 5_000: [(0, "stdout", "x" * 2_000)],
}


@pytest.mark.parametrize(("output", "lines"), LINES.items())
@pytest.mark.parametrize("size", [10_000, 1, 7], ids="in pieces of {}".format)
def test_output_becomes_lines_wherever_it_is_cut(
    output: bytes, lines: list[tuple[int, str, str]], size: int
) -> None:
    assert said(*(output[at : at + size] for at in range(0, len(output), size))) == lines


FORGED_MARKS = ["²", "٣", "-1", "1.5", "9" * 19, "9" * 30, "1_000", " 5", "+5", "0x5", "101"]


@pytest.mark.parametrize("time", FORGED_MARKS)
def test_a_forged_mark_is_text(time: str) -> None:
    """Not a number, or a time that the node can't have come to."""
    lines = said(f"{MARK}50\n{MARK}{time}\nnext\n".encode(), limit=100)

    assert lines == [(50, "stdout", f"{MARK}{time}"), (50, "stdout", "next")]


@settings(derandomize=True, deadline=None, max_examples=200)
@given(
    st.lists(st.binary(max_size=60) | st.text(f"{MARK}0123456789\n²", max_size=30).map(str.encode))
)
def test_any_output_gives_lines_in_order(pieces: list[bytes]) -> None:
    times = [time for time, _, _ in said(*pieces, limit=1_000)]

    assert times == sorted(times)
    assert all(time <= 1_000 for time in times)


def test_too_much_output_is_cut() -> None:
    long, many = Output("stdout"), Output("stdout")
    for _ in range(40):
        long.feed(b"x" * 32_000 + b"\n")
    many.feed(b"\n" * (MAX_LINES + 1))

    assert (long.truncated, many.truncated) == (True, True)
    assert sum(len(line.text) for line in long.lines) <= MAX_OUTPUT
    assert len(many.lines) == MAX_LINES
