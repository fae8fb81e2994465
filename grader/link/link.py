"""The judge's end of the link: frames to and from one host, and what the host prints.

Everything that comes from the host is hostile: sizes are checked before anything is read, frames
are decoded into fixed structures, text is capped, and nothing makes the judge wait for ever.
"""

from __future__ import annotations

import contextlib
import os
import re
import select
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import msgspec

from grader.host.frames import (
    LENGTH,
    MARK,
    MAX_FRAME,
    Ended,
    FromScript,
    LoadModels,
    Predict,
    Run,
    Script,
    Settled,
    Slept,
    Start,
    ToHost,
    ToJudge,
    decode_from_script,
    decode_to_judge,
    encode,
)
from grader.link.hosts import HostProcess
from grader.link.log import LogLine
from grader.link.run_queue import RunQueue

MAX_OUTPUT = 512 * 1024  # [bytes] of stdout and stderr each that are kept
MAX_LINES = 20_000  # of stdout and stderr each that are kept
CHUNK = 65536  # [bytes] read at once; as much as a pipe holds
DRAINS = 16  # chunks read at the end, from a host that may still be writing
DRAIN_EVERY = 16  # exchanges
PATROL = 0.02  # [s] after which the judge, waiting for an answer, reads output as it comes
MAX_REASON = 300  # [characters] of why a frame was refused: it may quote the frame
UNEXPLAINED = 0.02  # [s] of an exchange without CPU time: something was waited for
STACK_TIME = 0.3  # [s] a hung host gets for writing its stacks
TIME_MARK = re.compile(rf"(.*){MARK}([0-9]{{1,19}})")
ROS_LINE = re.compile(r"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[([^\]]*)\]: (.*)")


Answer = TypeVar("Answer")


class HostDied(Exception):
    """The process ended without saying so (`os._exit`, a crash of native code, killed)."""


class HostHung(Exception):
    """The host did not answer within its wall time; `stacks` says where it was."""

    def __init__(self, stacks: str) -> None:
        super().__init__("no answer")
        self.stacks = stacks


class HostForged(Exception):
    """The host sent what no node can say."""


@dataclass
class Output:
    """What came through one of the host's output pipes."""

    stream: str
    lines: list[LogLine] = field(default_factory=list)
    truncated: bool = False
    limit: int = 0  # [ns] no time mark can be later: the node's time has not gone further
    clock: int = 0  # [ns] when the next line is said, unless a mark tells
    _partial: bytes = b""
    _size: int = 0

    def feed(self, data: bytes) -> None:
        """Take in a piece of output; past the cap it is dropped."""
        self._size += len(data)
        if self._size > MAX_OUTPUT:
            self.truncated = True
            return
        *lines, self._partial = (self._partial + data).split(b"\n")
        for line in lines:
            self._line(line.decode("utf-8", "replace"))

    def finish(self) -> None:
        """Take the last, unfinished line."""
        if self._partial:
            self._line(self._partial.decode("utf-8", "replace"))
            self._partial = b""

    def _line(self, text: str) -> None:
        mark = TIME_MARK.fullmatch(text)
        if mark is not None and self.clock <= int(mark[2]) <= self.limit:
            if mark[1]:
                self._keep(mark[1])
            self.clock = int(mark[2])
        else:
            self._keep(text)

    def _keep(self, text: str) -> None:
        if len(self.lines) >= MAX_LINES:
            self.truncated = True
            return
        match = ROS_LINE.match(text)
        level, said = (match[1].lower(), match[3]) if match else (self.stream, text)
        self.lines.append(LogLine(self.clock, level, said.rstrip("\r")[:2_000]))


@dataclass(frozen=True)
class Cost:
    """What one exchange cost the host."""

    wall: float  # [s]
    cpu: float  # [s]; nan where the system doesn't tell
    queued: float = 0.0  # [s] waited for a CPU, by host or judge; measured only if wall >> cpu


class Channel:
    """The pipes between the judge and one host."""

    largest = MAX_FRAME  # [bytes]

    def __init__(self, host: HostProcess) -> None:
        self._host = host
        self._buffer = bytearray()
        self.stdout = Output("stdout")
        self.stderr = Output("stderr")
        self._pipes = {host.stdout: self.stdout, host.stderr: self.stderr}
        self._cpu_clock = ~host.pid << 3 | 2  # the clock of another process (clock_getcpuclockid)

    def log(self) -> tuple[LogLine, ...]:
        """Return what the node said so far, in order of time."""
        for fd in self._pipes:
            for _ in range(DRAINS):
                self._drain(fd)
        for output in (self.stdout, self.stderr):
            output.finish()
        return tuple(sorted(self.stdout.lines + self.stderr.lines, key=lambda line: line.time))

    def cpu(self) -> float:
        """Return the CPU time that the host has used [s]; nan where the system doesn't tell."""
        try:
            return time.clock_gettime(self._cpu_clock)
        except OSError:
            return float("nan")

    def _write(self, frame: ToHost, deadline: float) -> None:
        """Send a frame before the deadline, of `time.perf_counter` [s]."""
        data = memoryview(encode(frame))
        room = select.poll()
        room.register(self._host.link_out, select.POLLOUT)
        while data:
            remaining = deadline - time.perf_counter()
            if remaining <= 0 or not room.poll(remaining * 1e3):
                raise HostHung(self.stacks())
            try:
                data = data[os.write(self._host.link_out, data) :]
            except BrokenPipeError:
                raise HostDied from None

    def _read(self, fd: int) -> None:
        chunk = os.read(fd, CHUNK)
        if not chunk:
            raise HostDied
        self._buffer += chunk

    def _take_frame(self) -> bytes | None:
        if len(self._buffer) < LENGTH.size:
            return None
        (length,) = LENGTH.unpack_from(self._buffer)
        if length > self.largest:
            raise HostForged(f"a frame of {length} bytes")
        end = LENGTH.size + length
        if len(self._buffer) < end:
            return None
        body = bytes(self._buffer[LENGTH.size : end])
        del self._buffer[:end]
        return body

    def _drain_all(self) -> None:
        for fd in self._pipes:
            self._drain(fd)

    def _drain(self, fd: int) -> None:
        with contextlib.suppress(BlockingIOError):
            self._pipes[fd].feed(os.read(fd, CHUNK))

    def stacks(self) -> str:
        """Return where the hung host is, in the student's terms."""
        for _ in range(DRAINS):
            self._drain(self._host.stderr)
        before = len(self.stderr.lines)
        self._host.dump_stacks()
        deadline = time.perf_counter() + STACK_TIME
        said = select.poll()
        said.register(self._host.stderr, select.POLLIN)
        while (remaining := deadline - time.perf_counter()) > 0:
            if any(event & select.POLLIN for _, event in said.poll(remaining * 1e3)):
                self._drain(self._host.stderr)
            else:
                break
        return "\n".join(line.text for line in self.stderr.lines[before:])


def decoded(body: bytes, decode: Callable[[bytes], Answer]) -> Answer:
    """Decode a frame of a host; HostForged if it isn't one."""
    try:
        return decode(body)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise HostForged(str(error)[:MAX_REASON]) from None


class Link(Channel):
    """Frames to and from one host, in turns: it answers each question once."""

    def __init__(self, host: HostProcess) -> None:
        super().__init__(host)
        self._exchanges = 0
        self._queues = (RunQueue(host.pid), RunQueue(os.getpid()))
        self._answers = select.poll()
        self._answers.register(host.link_in, select.POLLIN)
        self._all = select.poll()
        for fd in (host.link_in, host.stdout, host.stderr):
            self._all.register(fd, select.POLLIN)

    def start(self, frame: Start, limit: float) -> tuple[ToJudge, Cost]:
        """Run the student's file up to the point where it waits; limit [s] of wall time."""
        answer, cost = self._exchange(frame, 0, limit, decode_to_judge)
        self._queued()  # what was waited for until now
        return answer, cost

    def run(self, frame: Run, limit: float) -> tuple[Settled | Ended, Cost]:
        """Let the node go on; limit [s] of wall time.

        Raises
        ------
        HostDied, HostHung, HostForged
            The process ended, did not answer in time, or sent nonsense.
        """
        answer, cost = self._exchange(frame, frame.until, limit, decode_to_judge)
        if isinstance(answer, Slept):
            raise HostForged("a start in the middle of the trial")
        return answer, cost

    def ask(self, frame: Script | LoadModels | Predict, limit: float) -> tuple[FromScript, Cost]:
        """Give an order to a host that runs scripts; it raises as `run` does."""
        return self._exchange(frame, 0, limit, decode_from_script)

    def _exchange(
        self, frame: ToHost, until: int, limit: float, decode: Callable[[bytes], Answer]
    ) -> tuple[Answer, Cost]:
        self._expect_silence()
        self.stdout.limit = self.stderr.limit = until
        started, cpu = time.perf_counter(), self.cpu()
        self._write(frame, started + limit)
        body = self._receive(started + limit)
        wall, cpu = time.perf_counter() - started, self.cpu() - cpu
        queued = self._queued() if wall - cpu > UNEXPLAINED else 0.0
        return decoded(body, decode), Cost(wall, cpu, queued)

    def _queued(self) -> float:
        """Return how long host and judge have waited for a CPU since the last call [s]."""
        return sum(queue.worst() for queue in self._queues)

    def _expect_silence(self) -> None:
        """Make sure that the host has not answered before it was asked."""
        early = bytes(self._buffer)
        if not early:
            try:
                early = os.read(self._host.link_in, 1)
            except BlockingIOError:
                return
        raise HostForged("an answer before the question") if early else HostDied

    def _receive(self, deadline: float) -> bytes:
        # At first output alone does not wake the judge: that would double the cost of an exchange.
        source = self._answers
        while (body := self._take_frame()) is None:
            remaining = deadline - time.perf_counter()
            if remaining <= 0:
                raise HostHung(self.stacks())
            ready = source.poll(min(remaining, PATROL) * 1e3)
            if not ready:
                source = self._all
            for fd, event in ready:
                if fd == self._host.link_in:
                    self._read(fd)
                elif event & select.POLLIN:
                    self._drain(fd)
                else:  # closed by the host
                    self._all.unregister(fd)
        self._exchanges += 1
        if self._exchanges % DRAIN_EVERY == 0:
            self._drain_all()
        return body
