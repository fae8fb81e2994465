"""A host in the judge's own process: no pipes, no fork, no threads of ours.

This is how a lesson's page drives a node in the reader's browser. The node runs on top of the
judge's stack: the judge's side of a trial is a conversation, and the host's end of the wire goes on
with it whenever the node has come as far as was agreed.

Nothing keeps such a node from anything: it is for one's own code, where there is no other process
to be had. It also leaves its traces in the process. So each trial begins in a fresh copy of one
that has warmed up, a fork or an image of memory, and all that comes out of it is the recording.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Generic, NoReturn, Protocol, cast

from rclpy_virtual_time.host import forkserver, imports, practice
from rclpy_virtual_time.host.frames import Carried, FromScript, Run, Start, Task, ToHost, ToJudge
from rclpy_virtual_time.host.tasks import carried_out
from rclpy_virtual_time.host.wire import Wire, flush_output
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.exchange import Cost, HostDied
from rclpy_virtual_time.link.launcher import FOREIGN_CODE
from rclpy_virtual_time.link.link import Conversation, Link, Result
from rclpy_virtual_time.link.log import LogLine
from rclpy_virtual_time.link.output import MAX_OUTPUT, Output, in_order
from rclpy_virtual_time.link.practice import PRACTICE
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.settings import IN_BROWSER, NO_GPU, SAME_RUNS
from rclpy_virtual_time.link.workplace import Workplace

TELL_EVERY = 0.5  # [s]


class StartEarlier(Exception):
    """The program has to be started before the scenario, which takes a fresh copy of the process.

    `lead` [ns] is what `run_trial` takes for it.
    """

    def __init__(self, lead: int) -> None:
        super().__init__(f"{lead} ns")
        self.lead = lead


class _Over(BaseException):
    """The trial is over: what is left of the student's program is unwound."""


class Stacks(Protocol):
    """Where the programs of a trial run, and how they end."""

    def run(self, body: Callable[[], object]) -> None:
        """Run the programs until the trial is over."""

    def leave(self) -> NoReturn:
        """End the trial, from one of its programs."""


class _OneStack:
    """The judge's own stack: programs without threads (an end in another thread goes unnoticed)."""

    def run(self, body: Callable[[], object]) -> None:
        with contextlib.suppress(_Over):
            body()

    def leave(self) -> NoReturn:
        raise _Over


class InProcess:
    """The launcher of one host in this process.

    `rclpy_portable` is activated, and keeps the machine's clock for its stamps (see
    `PORTABLE_PRELUDE`). Making it puts virtual time under Python, for good: make it once,
    before the process is copied. `reached` is told from time to time how far a trial has come [s].
    `stacks` are for programs with threads.
    """

    isolation = IN_BROWSER
    practice = PRACTICE
    foreign_code = FOREIGN_CODE
    guards_files = False

    def __init__(
        self,
        epoch: int,
        reached: Callable[[float], object] = lambda _: None,
        stacks: Stacks | None = None,
        advice: str = "",
        libraries: Sequence[str] = (),
    ) -> None:
        self.reached = reached
        self.stacks = stacks or _OneStack()
        os.environ.update({**SAME_RUNS, **NO_GPU})  # rclpy reads some of it once
        self._epoch = epoch
        self._kernel = forkserver.prepare_nodes(epoch)
        forkserver.settle(advice, libraries)
        self._used = False

    @property
    def now(self) -> float:
        """Where the node's time stands, since the scenario's start [s]."""
        return self._kernel.now / 1e9

    @property
    def workshop(self) -> NoReturn:
        """Refuse: there is no host for scripts."""
        raise EngineError("training scripts can't be run here; use the installed course")

    def workplace(self, folder: Path) -> NoReturn:
        """Refuse: this process has a single host, once."""
        raise EngineError("there is one folder here, once; use the installed course")

    @contextlib.contextmanager
    def host(self, place: Path | Workplace) -> Iterator[Link]:
        """Be the host that works in a folder, once."""
        folder = place.folder if isinstance(place, Workplace) else place
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            yield _OwnLink(_Host(self, folder, {1: out.fileno(), 2: err.fileno()}))

    def hold(self, conversation: Conversation[Result], host: _Host) -> Result:
        """Run the programs of a trial until it is over, or they are; return how it ended.

        Raises StartEarlier: a second start, which comes from a first that found out about it.
        """
        wire = _OwnWire(conversation, host)
        if self._used:
            assert isinstance(wire.question, Start)
            raise StartEarlier(wire.question.lead)
        self._used = True
        with host.printing():
            self.stacks.run(lambda: forkserver.run_trial(self._kernel, self._epoch, wire))
        imports.host.leave()
        return wire.outcome()

    def carry_out(self, task: Task, host: _Host) -> Carried:
        """Carry out a task, which may run a program: so this takes a copy of its own.

        Raises HostDied: it has ended the process.
        """
        carried: list[Carried] = []
        with host.printing():
            self.stacks.run(lambda: carried.append(carried_out(task)))
        if not carried:
            raise HostDied
        return carried[0]


class _OwnLink(Link):
    """A link to a host on the same stack."""

    def __init__(self, host: _Host) -> None:
        super().__init__(host)
        self._own = host

    def converse(self, conversation: Conversation[Result]) -> Result:
        """Hold a conversation to its end; return what it returns."""
        return self._own.launcher.hold(conversation, self._own)

    def _carry_out(self, task: Task, limit: float) -> tuple[FromScript, Cost]:
        return self._own.launcher.carry_out(task, self._own), Cost(0.0, 0.0)


class _Host:
    """What the judge asks of a host besides the conversation; a `Transport` that carries none."""

    def __init__(self, launcher: InProcess, folder: Path, files: dict[int, int]) -> None:
        self.launcher = launcher
        self.stdout, self.stderr = Output("stdout"), Output("stderr")
        self._folder = folder
        self._files = files  # descriptors, by those that the node writes to
        self._outputs = {1: self.stdout, 2: self.stderr}
        self._taken = {1: 0, 2: 0}  # [bytes]
        self._status = 0

    @contextlib.contextmanager
    def printing(self) -> Iterator[None]:
        """Be in the node's folder; take what is written to 1 and 2, and an end of the process."""
        before, leave, folder = {fd: os.dup(fd) for fd in self._files}, os._exit, Path.cwd()
        flush_output()
        for fd, file in self._files.items():
            os.dup2(file, fd)
        practice.enter(str(self._folder))
        os._exit = self._exit
        try:
            yield
        finally:
            os._exit = leave
            flush_output()
            os.chdir(folder)
            for fd, descriptor in before.items():
                os.dup2(descriptor, fd)
                os.close(descriptor)
            self.read_output()

    def _exit(self, status: int = 0) -> NoReturn:
        self._status = status
        self.launcher.stacks.leave()

    def expect_silence(self) -> None:
        """Nothing can have come: on one stack, the host speaks only in its turn."""

    def exchange(self, data: bytes, limit: float) -> NoReturn:
        """Refuse: no bytes go this way."""
        raise EngineError("a host in the judge's process takes conversations only")

    def read_output(self) -> None:
        """Read the node's output."""
        for fd, file in self._files.items():
            while data := os.pread(file, MAX_OUTPUT, self._taken[fd]):
                self._taken[fd] += len(data)
                self._outputs[fd].feed(data)

    def log(self) -> tuple[LogLine, ...]:
        """Return the node's output, in order of time."""
        return in_order(self.stdout, self.stderr)

    def stacks(self) -> str:
        """Return nothing: the judge is on the same stack."""
        return ""

    def wait(self, patience: float = 0.0) -> str:
        """Return the exit status."""
        return str(self._status)


class _OwnWire(Wire, Generic[Result]):
    """The host's end of the link where there is no link: it goes on with the judge's side."""

    def __init__(self, conversation: Conversation[Result], host: _Host) -> None:
        self._conversation = conversation
        self._host = host
        self._end: StopIteration | Exception | None = None
        self.question: Start | Run = next(conversation)[0]
        self._asked_at = 0.0, 0.0  # [s] of wall and of CPU time
        self._told = 0.0  # [s]

    def receive(self) -> ToHost:
        """Return the judge's frame; a program that asks after the end is unwound."""
        if self._end is not None:
            self._host.launcher.stacks.leave()
        until = self.question.until if isinstance(self.question, Run) else 0
        self._host.stdout.limit = self._host.stderr.limit = until
        self._asked_at = real_clock.perf_counter(), real_clock.process_time()
        if self._asked_at[0] > self._told + TELL_EVERY:
            self._told = self._asked_at[0]
            self._host.launcher.reached(until / 1e9)
        return self.question

    def send(self, frame: object) -> None:
        """Give an answer to the judge; the end of the trial unwinds the program."""
        wall, cpu = self._asked_at
        # a browser's clock of CPU time is none
        computed = math.nan if sys.platform == "emscripten" else real_clock.process_time() - cpu
        cost = Cost.uncounted(real_clock.perf_counter() - wall, computed)
        flush_output()
        if self._end is None:
            try:
                self.question, _ = self._conversation.send((cast(ToJudge, frame), cost))
            except (StopIteration, Exception) as end:
                self._end = end
        if self._end is not None:
            self._host.launcher.stacks.leave()

    def outcome(self) -> Result:
        """Return what the conversation returned; a program that said nothing at its end has died.

        Raises Exception: what the conversation raised.
        """
        if self._end is None:
            try:
                self._conversation.throw(HostDied())
            except StopIteration as end:
                self._end = end
        if not isinstance(self._end, StopIteration):
            assert self._end is not None
            raise self._end
        result: Result = self._end.value
        return result
