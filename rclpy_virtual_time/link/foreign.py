"""Foreign text on its way to a terminal: students' names, logs, exceptions, names of files.

It may hold sequences that clear the screen, set the window's title or type for whoever reads it.
"""

from __future__ import annotations

import re

_ESCAPES = re.compile(
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
    return _STACKED.sub(r"\1", _CONTROLS.sub("", _ESCAPES.sub("", text.replace("\r\n", "\n"))))
