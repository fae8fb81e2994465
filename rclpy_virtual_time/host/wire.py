"""The host's end of the link, byte by byte."""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Callable

from .frames import (
    LENGTH,
    MARK,
    MAX_TEXT,
    Ended,
    FromLive,
    FromRadio,
    FromScript,
    FromTest,
    ToHost,
    ToJudge,
    decode_to_host,
    encode,
)

ADDRESS = re.compile(r" at 0x[0-9a-f]+")
BUILT_IN = re.compile(r"<built-in method (\w+) of [^<>]*>")
MAX_LINE = MAX_TEXT // 10  # [characters]


class Wire:
    """Whole frames through two descriptors; the process ends when the judge is gone."""

    def __init__(self, read_fd: int, write_fd: int) -> None:
        self.read_fd = read_fd
        self._write_fd = write_fd

    def receive(self) -> ToHost:
        """Wait for the judge's next frame."""
        return decode_to_host(self.read_frame())

    def read_frame(self) -> bytes:
        """Wait for the body of the judge's next frame."""
        (length,) = LENGTH.unpack(self._read_exactly(LENGTH.size))
        return self._read_exactly(length)

    def send(self, frame: ToJudge | FromScript | FromTest | FromLive | FromRadio) -> None:
        """Send a frame, after all that was printed before it."""
        flush_output()
        data = memoryview(encode(frame))
        while data:
            data = data[os.write(self._write_fd, data) :]

    def _read_exactly(self, size: int) -> bytes:
        chunks = []
        while size:
            chunk = os.read(self.read_fd, size)
            if not chunk:
                os._exit(0)  # the judge is gone
            chunks.append(chunk)
            size -= len(chunk)
        return b"".join(chunks)


class Turns:
    """Marks in stdout and stderr: the time of writing, and the order of both at one moment."""

    def __init__(self) -> None:
        self._time = 0  # [ns]
        self._turn = 0
        self._speaks = 0  # descriptor
        self._whole = {1: True, 2: True}  # the last line that was written there has an end

    def install(self) -> None:
        """Watch what Python writes."""
        for fd, stream in ((1, sys.stdout), (2, sys.stderr)):
            stream.write = self._watched(fd, stream.write)  # type: ignore[method-assign]

    def begin(self, time: int) -> None:
        """Mark the time [ns] in both."""
        flush_output()
        self._time, self._turn, self._speaks = time, 0, 0
        for fd in (1, 2):
            self._mark(fd, f"{MARK}{time}\n")

    def take(self, fd: int) -> None:
        """Mark a change of turns, unless that would cut a line in two."""
        if fd == self._speaks or not self._whole[fd]:
            return
        flush_output()
        self._speaks = fd
        self._turn += 1
        self._mark(fd, f"{MARK}{self._time}.{self._turn}\n")

    def _watched(self, fd: int, write: Callable[[str], int]) -> Callable[[str], int]:
        def write_in_turn(text: str) -> int:
            self.take(fd)
            written = write(text)
            self._whole[fd] = text.endswith("\n") if text else self._whole[fd]
            return written

        return write_in_turn

    def _mark(self, fd: int, line: str) -> None:
        with contextlib.suppress(OSError):
            os.write(fd, line.encode())


def ended(kind: str, text: str, detail: str = "", now: int = 0) -> Ended:
    """Return the frame that says how a program ended."""
    return Ended(now, kind, sendable(text[:MAX_LINE]), sendable(detail[-MAX_TEXT + MAX_LINE :]), [])


def flush_output() -> None:
    """Flush the student's output before the next frame."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):
            stream.flush()


def steady(text: str) -> str:
    """Return a text without addresses, which differ from run to run and tell nothing."""
    return ADDRESS.sub("", BUILT_IN.sub(r"\1()", text))


def sendable(text: str) -> str:
    """Replace what UTF-8 can't carry: half characters, such as those in undecodable file names."""
    return text.encode("utf-8", "replace").decode()
