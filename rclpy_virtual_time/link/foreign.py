"""Foreign text on its way to a terminal: students' names, logs, exceptions, names of files.

It may hold sequences that clear the screen, set the window's title or type for whoever reads it. In
this package nothing else writes to a terminal but `echo` here and `Console` in `terminal.py`.
"""

from __future__ import annotations

import re
import sys

ESCAPES = re.compile(
    r"\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)?"  # OSC: window titles, links
    r"|[\x1b\x9b]\[?[0-?]*[ -/]*[@-~]"  # CSI and two-character sequences
)
# C0 and C1 but tab and newline; the bidi controls can make a line read backwards.
_CONTROLS = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069]"
)
# More accents than any script stacks would be drawn over the lines above and below.
_STACKED = re.compile(
    r"([\u0300-\u036f\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]{4})"
    r"[\u0300-\u036f\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]+"
)


def readable(text: str) -> str:
    """Return student text without escape sequences, control and bidi characters."""
    if text.isascii() and text.isprintable():  # as most of it is; a class has 100,000 such texts
        return text
    return _STACKED.sub(r"\1", _CONTROLS.sub("", ESCAPES.sub("", text.replace("\r\n", "\n"))))


def echo(text: object = "", *, err: bool = False) -> None:
    """Print lines that may quote what others wrote."""
    import click  # noqa: PLC0415  (the page's Python has none, and prints nothing)

    stream = sys.stderr if err else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    click.echo(readable(str(text)).encode(encoding, "replace").decode(encoding), err=err)


def write(text: str) -> None:
    """Write a document to stdout: as it is into a file or a pipe, readable on a terminal."""
    sys.stdout.write(readable(text) if sys.stdout.isatty() else text)
