"""The pipes to a host of Linux's: frames, what it prints, and how long the judge waits for it."""

import contextlib
import os
import select
import signal
from pathlib import Path

from rclpy_virtual_time.host.frames import LENGTH, MAX_FRAME
from rclpy_virtual_time.link.exchange import (
    STARVED,
    UNEXPLAINED,
    Cost,
    HostDied,
    HostForged,
    HostHung,
)
from rclpy_virtual_time.link.host_process import HostProcess
from rclpy_virtual_time.link.log import LogLine
from rclpy_virtual_time.link.output import Output, in_order
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.run_queue import RunQueue

CHUNK = 65536  # [bytes] read at once; as much as a pipe holds
DRAINS = 16  # chunks read at the end, from a host that may still be writing
PATROL = 0.02  # [s] after which the judge reads output as it comes, and looks at the host again
COUNTED = Path("/proc/self/schedstat").exists()  # waits for a CPU, by the kernel
STACK_TIME = 0.3  # [s] a hung host gets for writing a line of its stacks ...
MOST_STACK_TIME = 3.0  # [s] ... and all of them


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

    def log(self) -> tuple[LogLine, ...]:
        """Return what the node said so far, in order of time."""
        for _ in range(DRAINS):
            self.read_output()
        return in_order(self.stdout, self.stderr)

    def cpu(self) -> float:
        """Return the CPU time that the host has used [s]; nan where the system doesn't tell."""
        return real_clock.cpu_time(self._host.pid)

    def _patrol(self) -> None:
        """See now and then what the host takes of the machine.

        Raises Excess: it takes too much.
        """
        now = real_clock.perf_counter()
        if self._host.watch is not None and now - self._looked >= PATROL:
            self._looked = now
            self._host.watch.patrol()

    def _write(self, frame: bytes, deadline: float) -> None:
        """Send a frame before the deadline, of `real_clock.perf_counter` [s]."""
        data = memoryview(frame)
        room = select.poll()
        room.register(self._host.link_out, select.POLLOUT)
        while data:
            remaining = deadline - real_clock.perf_counter()
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

    def read_output(self) -> None:
        """Read the host's output, as much as a pipe holds."""
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
        deadline = real_clock.perf_counter() + MOST_STACK_TIME
        said = select.poll()
        said.register(self._host.stderr, select.POLLIN)
        for number in (signal.SIGUSR1, signal.SIGUSR2):
            self._host.dump_stacks(number)
            while any(event & select.POLLIN for _, event in said.poll(STACK_TIME * 1e3)):
                self._drain(self._host.stderr)
                if real_clock.perf_counter() > deadline:
                    break
            if len(self.stderr.lines) > before:
                break
        return "\n".join(line.text for line in self.stderr.lines[before:])


class Pipes(Channel):
    """One answer to each frame: the transport of a `Link`."""

    def __init__(self, host: HostProcess) -> None:
        super().__init__(host)
        self.wait = host.wait
        self._queues = (RunQueue(host.pid), RunQueue(os.getpid()))
        self._first = True
        self._answers = select.poll()
        self._answers.register(host.link_in, select.POLLIN)
        self._all = select.poll()
        for fd in (host.link_in, host.stdout, host.stderr):
            self._all.register(fd, select.POLLIN)

    def expect_silence(self) -> None:
        """Make sure that the host has not answered before the question, nor taken too much."""
        early: bytes | None = bytes(self._buffer) or None
        if early is None and self._answers.poll(0):
            early = os.read(self._host.link_in, 1)
        if early is not None:
            raise HostForged("an answer before the question") if early else HostDied
        if self._host.watch is not None:
            self._host.watch.look()

    def exchange(self, data: bytes, limit: float) -> tuple[bytes, Cost]:
        """Send a frame; return the body of the answer (see `Transport`)."""
        started, cpu = real_clock.perf_counter(), self.cpu()
        self._write(data, started + limit)
        body = self._receive(started, cpu, limit)
        wall, cpu = real_clock.perf_counter() - started, self.cpu() - cpu
        if not COUNTED:
            return body, Cost.uncounted(wall, cpu)
        first, self._first = self._first, False  # 0 then: what was waited for until now
        queued = self._queued() if first or wall - cpu > UNEXPLAINED else 0.0
        return body, Cost(wall, cpu, queued)

    def _queued(self) -> float:
        """Return how long host and judge have waited for a CPU since the last call [s]."""
        return sum(queue.worst() for queue in self._queues)

    def _receive(self, started: float, cpu: float, limit: float) -> bytes:
        """Wait for a frame, `limit` [s] from `started` on, when the host had used `cpu` [s].

        On a busy machine longer: a host that gets on, or would, has the limit in CPU time.
        """
        deadline, overdue, seen = started + limit, False, cpu
        # At first output alone does not wake the judge: that would double the cost of an exchange.
        source = self._answers
        while (body := self._take_frame()) is None:
            if overdue:
                before, seen = seen, self.cpu()
                starved = seen > before or self._host.is_ready()
                passed = real_clock.perf_counter() - started
                if not starved or passed >= STARVED * limit or seen - cpu >= limit:
                    raise HostHung(self.stacks())
            remaining = deadline - real_clock.perf_counter()
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
        return body
