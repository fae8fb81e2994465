"""A host that is a process of its own from the start: no fork, and nothing that only Linux has.

The judge's pipes are this process's stdin and stdout. They are taken away at once, before anything
else is imported; what the student's program prints goes to two files.
"""

from __future__ import annotations

import functools
import importlib.util
import inspect
import os
import sys
from pathlib import Path

import msgspec

from .frames import LENGTH, Request
from .kinds import NODES

BINARY = getattr(os, "O_BINARY", 0)  # Windows: no other line ends


def serve(kind: str, epoch: str, *rest: str) -> None:
    """Import what takes long, tell the judge, and run what it asks for; never returns.

    `rest` are the libraries to import, and the files for stdout and stderr.
    """
    *libraries, stdout, stderr = rest
    link_in, link_out = _take_pipes(stdout, stderr)
    if kind == NODES:
        from . import forkserver  # noqa: PLC0415
        from .virtual import kernel as kernel_module  # noqa: PLC0415
        from .virtual import threads  # noqa: PLC0415

        kernel = kernel_module.Kernel()
        threads.install(kernel, int(epoch))
        forkserver._warm_up()
        body = functools.partial(forkserver._run_student, kernel, int(epoch))
    else:
        from . import scripts  # noqa: PLC0415

        body = functools.partial(scripts.serve)
    for name in libraries:
        if importlib.util.find_spec(name.partition(".")[0]) is not None:
            importlib.import_module(name)
    inspect.getmodule(sys._getframe())  # it looks at all modules: a node's first log line would
    os.write(link_out, LENGTH.pack(0))  # ready
    _enter(msgspec.json.decode(_read_frame(link_in), type=Request).folder)
    body(link_in, link_out)
    os._exit(0)


def _take_pipes(stdout: str, stderr: str) -> tuple[int, int]:
    """Return descriptors of the link; let 0, 1 and 2 be nothing and the two files."""
    link_in, link_out = os.dup(0), os.dup(1)
    if BINARY:
        import msvcrt  # noqa: PLC0415

        for descriptor in (link_in, link_out):
            msvcrt.setmode(descriptor, BINARY)  # type: ignore[attr-defined]
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | BINARY
    for source, target in (
        (os.open(os.devnull, os.O_RDONLY), 0),
        (os.open(stdout, flags), 1),
        (os.open(stderr, flags), 2),
    ):
        os.dup2(source, target)
        os.close(source)
    return link_in, link_out


def _enter(folder: str) -> None:
    os.chdir(folder)
    for name in ("HOME", "USERPROFILE", "TMPDIR", "TEMP", "TMP", "ROS_LOG_DIR"):
        os.environ[name] = str(Path(folder))


def _read_frame(descriptor: int) -> bytes:
    (length,) = LENGTH.unpack(_read(descriptor, LENGTH.size))
    return _read(descriptor, length)


def _read(descriptor: int, size: int) -> bytes:
    data = b""
    while len(data) < size:
        chunk = os.read(descriptor, size - len(data))
        if not chunk:
            os._exit(0)  # the judge is gone
        data += chunk
    return data
