"""The judge's end of the link: frames to and from one host, in turns.

Everything that comes from the host is hostile: sizes are checked before anything is read, frames
are decoded into fixed structures, text is capped, and nothing makes the judge wait for ever.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from pathlib import Path
from typing import Protocol, TypeAlias, TypeVar

import msgspec

from rclpy_virtual_time.host import frames
from rclpy_virtual_time.link import exchange
from rclpy_virtual_time.link.exchange import Answer, Cost, HostForged, decoded, status_text
from rclpy_virtual_time.link.log import LogLine
from rclpy_virtual_time.link.output import Output

READ_EVERY = 16  # exchanges: what the host has printed

Result = TypeVar("Result")
# Yields what to send and the wall time for the answer [s]; gets the answer and what it cost.
Conversation = Generator[
    tuple[frames.Start | frames.Run, float], tuple[frames.ToJudge, Cost], Result
]


class Transport(Protocol):
    """How bytes come to one host and back: Linux's pipes, or a process on any system."""

    stdout: Output
    stderr: Output

    def expect_silence(self) -> None:
        """Make sure, before a question, that the host has not answered; raises as `exchange`."""

    def exchange(self, data: bytes, limit: float) -> tuple[bytes, Cost]:
        """Send a frame; return the body of the answer, after `limit` [s] of wall time at most.

        Raises HostDied, HostHung, HostForged, Excess: the process ended, did not answer in time,
        sent nonsense, or took too much.
        """

    def read_output(self) -> None:
        """Read the host's output."""

    def log(self) -> tuple[LogLine, ...]:
        """Return the host's output so far, in order of time."""

    def stacks(self) -> str:
        """Return the stacks of the host's threads; "" where they can't be had."""

    def wait(self, patience: float = 0.0) -> str:
        """Wait for the host's end, for `patience` [s]; return its exit status."""


class Link:
    """Frames to and from one host, in turns: it answers each question once."""

    Cost: TypeAlias = exchange.Cost
    Moment: TypeAlias = frames.Moment

    def __init__(self, host: Transport) -> None:
        self._host = host
        self._exchanges = 0
        self.stdout, self.stderr = host.stdout, host.stderr
        self.log, self.stacks = host.log, host.stacks

    def wait(self, patience: float = 0.0) -> str:
        """Wait for the host's end, for `patience` [s]; say its exit status in words."""
        return status_text(self._host.wait(patience))

    def converse(self, conversation: Conversation[Result]) -> Result:
        """Hold a conversation to its end; return what it returns.

        What `run` raises is raised in it, where it waits for the answer. An end that can't wait
        for its host, because it shares its thread, holds conversations in its own way.
        """
        try:
            question = next(conversation)
            while True:
                try:
                    answer = self.run(*question)
                except Exception as error:
                    question = conversation.throw(error)
                else:
                    question = conversation.send(answer)
        except StopIteration as end:
            result: Result = end.value
            return result

    def run(self, frame: frames.Start | frames.Run, limit: float) -> tuple[frames.ToJudge, Cost]:
        """Run the student's file up to the point where it waits, or let the node go on.

        It raises as `Transport.exchange` does; limit [s] is of wall time.
        """
        return self._exchange(frame, limit, frames.decode_to_judge)

    def run_script(
        self, file: Path, arguments: tuple[str, ...], seed: int, limit: float
    ) -> tuple[frames.Ended, Cost]:
        """Run a program that returns, in real time; it raises as `run` does.

        `seed` is that of `random` and of numpy's generator, below 2**32.
        """
        script = frames.Script(str(file), arguments, seed)
        answer, cost = self._exchange(script, limit, frames.decode_from_script)
        if not isinstance(answer, frames.Ended):
            raise HostForged("an answer to another order")
        return answer, cost

    def carry_out(
        self, function: str, order: msgspec.Struct, answer: type[Answer], limit: float
    ) -> tuple[Answer, Cost]:
        """Have a function of a module carry out an order; return its answer.

        Its launcher has to have imported the module ("module:function"), as one of its libraries.
        It raises as `run` does.
        """
        task = frames.Task(function, msgspec.msgpack.encode(order))
        said, cost = self._carry_out(task, limit)
        if not isinstance(said, frames.Carried):
            raise HostForged("an answer to another order")
        return decoded(said.data, msgspec.msgpack.Decoder(answer).decode), cost

    def _carry_out(self, task: frames.Task, limit: float) -> tuple[frames.FromScript, Cost]:
        return self._exchange(task, limit, frames.decode_from_script)

    def _exchange(
        self, frame: frames.ToHost, limit: float, decode: Callable[[bytes], Answer]
    ) -> tuple[Answer, Cost]:
        self._host.expect_silence()
        self.stdout.limit = self.stderr.limit = frame.until if isinstance(frame, frames.Run) else 0
        body, cost = self._host.exchange(frames.encode(frame), limit)
        self._exchanges += 1
        if self._exchanges % READ_EVERY == 0:
            self._host.read_output()
        return decoded(body, decode), cost
