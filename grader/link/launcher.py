"""What starts hosts, as the rest of the grader sees it: with Linux's means, or without.

`grader.link.hosts` has Linux's: a fork server and layers of isolation. `grader.link.practice` needs
nothing but Python.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from grader.host.frames import (
    Ended,
    FromScript,
    LoadModels,
    Predict,
    Run,
    Script,
    Settled,
    Start,
    ToJudge,
)
from grader.link.exchange import Cost
from grader.link.log import LogLine
from grader.link.output import Output
from grader.link.workplace import Workplace


class Dialogue(Protocol):
    """Frames to and from one host, in turns; grader.link.exchange has what it raises."""

    stdout: Output
    stderr: Output

    def start(self, frame: Start, limit: float) -> tuple[ToJudge, Cost]:
        """Run the student's file up to the point where it waits; limit [s] of wall time."""

    def go_on(self, frame: Run, limit: float) -> tuple[ToJudge, Cost]:
        """Let a start-up go on that had a question; it raises as `run` does."""

    def run(self, frame: Run, limit: float) -> tuple[Settled | Ended, Cost]:
        """Let the node go on; limit [s] of wall time."""

    def ask(self, frame: Script | LoadModels | Predict, limit: float) -> tuple[FromScript, Cost]:
        """Give an order to a host that runs scripts."""

    def log(self) -> tuple[LogLine, ...]:
        """Return what the node said so far, in order of time."""

    def stacks(self) -> str:
        """Return where the host's threads are; "" where that can't be told."""


class Host(Protocol):
    """One host."""

    def link(self) -> Dialogue:
        """Open the judge's end of the link."""

    def wait(self, patience: float = 0.0) -> str:
        """Wait for its end, for `patience` [s]; return its exit status."""


class Launcher(Protocol):
    """Starts hosts."""

    @property
    def isolation(self) -> str:
        """What stands between students' code and this machine."""

    @property
    def practice(self) -> str:
        """Why a grading made here is for practice only; "" if it isn't."""

    @property
    def workshop(self) -> Launcher:
        """The launcher of hosts for scripts that goes with this one."""

    def workplace(self, folder: Path) -> AbstractContextManager[Workplace]:
        """Make a folder one that several hosts work in, one after another."""

    def host(
        self, place: Path | Workplace, *, priority: bool = False
    ) -> AbstractContextManager[Host]:
        """Start a host that works in a folder; it is dead when the block ends."""
