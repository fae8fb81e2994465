"""A host that the test plays itself: real pipes, and a thread that answers each frame as told."""

from __future__ import annotations

import contextlib
import itertools
import os
import threading
from collections.abc import Iterable, Iterator

import msgspec

from rclpy_virtual_time.host.frames import LENGTH, Settled, encode
from rclpy_virtual_time.link.host_process import HostProcess

SETTLED = Settled(now=0, spinning=True, asleep=False, published=[])


class FakeHost(HostProcess):
    """The judge's handle; `answers` are sent as they are, one for each frame of the judge."""

    def __init__(
        self, answers: Iterable[bytes], *, hang_up: bool = True, deaf: bool = False
    ) -> None:
        self._answers = list(answers)
        self._hang_up = hang_up
        self._deaf = deaf
        self.their_in, link_out = os.pipe()
        link_in, self.their_out = os.pipe()
        stdout, self.their_stdout = os.pipe()
        stderr, self.their_stderr = os.pipe()
        status, self.their_status = os.pipe()
        for fd in (link_out, link_in, stdout, stderr):
            os.set_blocking(fd, False)
        super().__init__(os.getpid(), -1, link_out, link_in, stdout, stderr, status)
        self.killed = False
        self.ready: Iterator[bool] = itertools.repeat(False)  # is_ready says so
        self._thread = threading.Thread(target=self._serve)

    def kill(self) -> None:
        self.killed = True
        os.write(self.their_status, b"+-9\n")

    def is_ready(self) -> bool:
        return next(self.ready)

    def dump_stacks(self, _: int = 0) -> None:
        with contextlib.suppress(BlockingIOError):  # a full pipe loses it, as faulthandler does
            os.write(self.their_stderr, b'  File "agent.py", line 7 in on_scan\n')

    def _serve(self) -> None:
        with contextlib.suppress(BrokenPipeError):
            for answer in self._answers:
                if not self._deaf and not self._hear():
                    return
                write_all(self.their_out, answer)
            if self._hang_up:
                os.close(self.their_out)
                self.their_out = -1

    def _hear(self) -> bool:
        """Take one frame from the judge; False if the judge has hung up."""
        head = read_exactly(self.their_in, LENGTH.size)
        return len(head) == LENGTH.size and bool(
            read_exactly(self.their_in, LENGTH.unpack(head)[0])
        )

    def __enter__(self) -> FakeHost:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self.link_out)
        os.close(self.link_in)
        self._thread.join()
        theirs = (self.their_in, self.their_out, self.their_stdout, self.their_stderr)
        for fd in (*theirs, self.their_status, self.stdout, self.stderr, self.status):
            if fd >= 0:
                os.close(fd)


def write_all(fd: int, data: bytes) -> None:
    rest = memoryview(data)
    while rest:
        rest = rest[os.write(fd, rest) :]


def read_exactly(fd: int, size: int) -> bytes:
    data = b""
    while len(data) < size and (chunk := os.read(fd, size - len(data))):
        data += chunk
    return data


def frame(body: object) -> bytes:
    """Frame anything at all."""
    data = body if isinstance(body, bytes) else msgspec.msgpack.encode(body)
    return LENGTH.pack(len(data)) + data


def settled(now: int = 0, **fields: object) -> bytes:
    return encode(msgspec.structs.replace(SETTLED, now=now, **fields))


@contextlib.contextmanager
def talking(fd: int, data: bytes) -> Iterator[None]:
    """Write `data` again and again, as fast as it is read, until the block ends."""
    stop = threading.Event()

    def talk() -> None:
        os.set_blocking(fd, False)
        while not stop.is_set():
            with contextlib.suppress(BlockingIOError):
                os.write(fd, data)

    thread = threading.Thread(target=talk)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
