"""The judge's end of the link: frames to and from one host, and what the host prints.

Everything that comes from the host is hostile: sizes are checked before anything is read, frames
are decoded into fixed structures, text is capped, and nothing makes the judge wait for ever.
"""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Callable

from grader.host.frames import (
    LENGTH,
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
from grader.link.exchange import Answer, Cost, HostDied, HostForged, HostHung, decoded
from grader.link.host_process import HostProcess
from grader.link.log import LogLine
from grader.link.output import Output
from grader.link.run_queue import RunQueue

CHUNK = 65536  # [bytes] read at once; as much as a pipe holds
DRAINS = 16  # chunks read at the end, from a host that may still be writing
DRAIN_EVERY = 16  # exchanges
PATROL = 0.02  # [s] after which the judge reads output as it comes, and looks at the host again
UNEXPLAINED = 0.02  # [s] of an exchange without CPU time: something was waited for
STARVED = 4  # times its limit a host may take that the machine does not let run
STACK_TIME = 0.3  # [s] a hung host gets for writing its stacks


class Channel:
    """The pipes between the judge and one host."""

    largest = MAX_FRAME  # [bytes]

    def __init__(self, host: HostProcess) -> None:
        self._host = host
        self._buffer = bytearray()
        self.stdout = Output("stdout")
        self.stderr = Output("stderr")
        self._pipes = {host.stdout: self.stdout, host.stderr: self.stderr}
        self._looked = -PATROL
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

    def _patrol(self) -> None:
        """See now and then what the host takes of the machine.

        Raises
        ------
        Excess
            It takes too much.
        """
        now = time.perf_counter()
        if self._host.watch is not None and now - self._looked >= PATROL:
            self._looked = now
            self._host.watch.patrol()

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

    def go_on(self, frame: Run, limit: float) -> tuple[ToJudge, Cost]:
        """Let a start-up go on that had a question; it raises as `run` does."""
        return self._exchange(frame, frame.until, limit, decode_to_judge)

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
        if self._host.watch is not None:
            self._host.watch.look()
        self.stdout.limit = self.stderr.limit = until
        started, cpu = time.perf_counter(), self.cpu()
        self._write(frame, started + limit)
        body = self._receive(started, cpu, limit)
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

    def _receive(self, started: float, cpu: float, limit: float) -> bytes:
        """Wait for a frame, `limit` [s] from `started` on, when the host had used `cpu` [s].

        On a busy machine longer: a host that is ready to run has the limit in CPU time.
        """
        deadline, overdue = started + limit, False
        # At first output alone does not wake the judge: that would double the cost of an exchange.
        source = self._answers
        while (body := self._take_frame()) is None:
            if overdue and not self._is_starved(started, cpu, limit):
                raise HostHung(self.stacks())
            remaining = deadline - time.perf_counter()
            overdue = remaining <= 0  # yet what has come meanwhile is read
            ready = source.poll((PATROL if overdue else min(remaining, PATROL)) * 1e3)
            self._patrol()
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

    def _is_starved(self, started: float, cpu: float, limit: float) -> bool:
        """Tell whether it is the machine that keeps the host from answering."""
        passed, used = time.perf_counter() - started, self.cpu() - cpu
        return passed < STARVED * limit and not used >= limit and self._host.is_ready()
