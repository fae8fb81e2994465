"""A host for programs that return, in real time, and for tasks.

The judge gives one order at a time: run this script, or carry out this task.
"""

from __future__ import annotations

from pathlib import Path

from . import imports, program, randomness
from .frames import Ended, FromScript, ProgramStart, Script, Task
from .tasks import carried_out
from .wire import Wire, ended


def serve(read_fd: int, write_fd: int) -> None:
    """Carry out the judge's orders until it is gone; never returns."""
    wire = Wire(read_fd, write_fd)
    while True:
        match wire.receive():
            case Script() as order:
                answer: FromScript = _run(order)
            case Task() as order:
                answer = carried_out(order)
            case other:
                raise ValueError(f"{type(other).__name__} is for nodes")
        wire.send(answer)


def _run(order: Script) -> Ended:
    randomness.seed(order.seed)  # a fork inherits the fork server's generators
    imports.host.enter([str(Path(order.file).parent)])
    kind, text, detail = program.run_file(ProgramStart(order.file, order.arguments))
    return ended(kind, text, detail)
