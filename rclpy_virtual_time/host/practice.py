"""A host that is a process of its own from the start: no fork, and nothing that only Linux has.

The judge's pipes are this process's stdin and stdout. They are taken away at once, before anything
else is imported; what the student's program prints goes to two files.
"""

from __future__ import annotations

import os
from pathlib import Path

import msgspec

from .frames import LENGTH, Request
from .wire import Wire

BINARY = getattr(os, "O_BINARY", 0)  # Windows: no other line ends


def serve(kind: str, epoch: str, advice: str, *rest: str) -> None:
    """Do the long imports, tell the judge, and run its orders; never returns.

    `rest` are the libraries to import, and the files for stdout and stderr.
    """
    *libraries, stdout, stderr = rest
    link_in, link_out = _take_pipes(stdout, stderr)
    from . import forkserver  # noqa: PLC0415  (only now are the pipes safe from what it prints)

    body = forkserver.prepared(kind, int(epoch), advice, libraries)
    os.write(link_out, LENGTH.pack(0))  # ready
    enter(msgspec.json.decode(Wire(link_in, link_out).read_frame(), type=Request).folder)
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


def enter(folder: str) -> None:
    """Work in a folder: of a node, or of what it asks for."""
    os.chdir(folder)
    home = Path(folder, ".home")  # what lies beside a node does not lie in ~
    home.mkdir(exist_ok=True)
    for name in ("TMPDIR", "TEMP", "TMP", "ROS_LOG_DIR"):
        os.environ[name] = str(Path(folder))
    os.environ["HOME"] = os.environ["USERPROFILE"] = str(home)
