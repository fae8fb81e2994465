"""Lines on a terminal that may quote what others wrote: names, logs, exceptions, files.

In the grader nothing else writes to a terminal but this and `Console` in `terminal.py`.
"""

from __future__ import annotations

import sys

import click

from rclpy_virtual_time import readable


def echo(text: object = "", *, err: bool = False) -> None:
    """Print lines that may quote what others wrote."""
    stream = sys.stderr if err else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    click.echo(readable(str(text)).encode(encoding, "replace").decode(encoding), err=err)


def write(text: str) -> None:
    """Write a document to stdout: as it is into a file or a pipe, readable on a terminal."""
    sys.stdout.write(readable(text) if sys.stdout.isatty() else text)
