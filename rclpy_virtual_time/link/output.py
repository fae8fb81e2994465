"""What a host prints: lines with the times at which they were said, and no more than a cap."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from rclpy_virtual_time.host.frames import MARK
from rclpy_virtual_time.link.log import LogLine

MAX_OUTPUT = 512 * 1024  # [bytes] of stdout and stderr each that are kept
MAX_LINES = 20_000  # of stdout and stderr each that are kept
TIME_MARK = re.compile(rf"(.*){MARK}([0-9]{{1,19}})(?:\.([0-9]{{1,9}}))?")
ROS_LINE = re.compile(r"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[([^\]]*)\]: (.*)")


@dataclass
class Output:
    """What came through one of the host's output pipes."""

    stream: str
    lines: list[LogLine] = field(default_factory=list)
    truncated: bool = False
    limit: int = 0  # [ns] no time mark can be later: the node's time has not gone further
    clock: int = 0  # [ns] when the next line is said, unless a mark tells
    turns: list[int] = field(default_factory=list)  # of the lines, among those of their time
    _turn: int = 0
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
            self.clock, self._turn = int(mark[2]), int(mark[3] or 0)
        else:
            self._keep(text)

    def _keep(self, text: str) -> None:
        if len(self.lines) >= MAX_LINES:
            self.truncated = True
            return
        match = ROS_LINE.match(text)
        level, said = (match[1].lower(), match[3]) if match else (self.stream, text)
        self.turns.append(self._turn)
        self.lines.append(LogLine(self.clock, level, said.rstrip("\r")[:2_000]))


def in_order(stdout: Output, stderr: Output) -> tuple[LogLine, ...]:
    """Return the lines of both, in order of time; the last may be unfinished."""
    for output in (stdout, stderr):
        output.finish()
    turns = stdout.turns + stderr.turns
    said = zip(stdout.lines + stderr.lines, turns, strict=True)
    return tuple(line for line, _ in sorted(said, key=lambda each: (each[0].time, each[1])))
