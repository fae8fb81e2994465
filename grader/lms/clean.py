"""Make students' text harmless where it goes: on a page, in a spreadsheet or XML."""

import re

from rclpy_virtual_time import readable

MAX_NAME = 120  # [characters] of a name on a page

# C0 and C1 but tab and newline, bidi controls, line separators, surrogates, non-characters.
_UNSEEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069"
    "\ud800-\udfff\ufdd0-\ufdef\ufeff\ufffe\uffff]"
)
# What may begin a formula in a spreadsheet (OWASP, "CSV Injection"), full-width forms included.
_FORMULA = ("=", "+", "-", "@", "\uff1d", "\uff0b", "\uff0d", "\uff20")
_FIGURE = re.compile(r"[-+]?\d+([.,]\d+)?")


def visible(text: object) -> str:
    """Return text for people: no escape sequences, no control or bidi characters.

    XML 1.0 ("Characters", section 2.2) and UTF-8 allow what remains.
    """
    return _UNSEEN.sub("", readable(str(text)))


def one_line(text: object, most: int = MAX_NAME) -> str:
    """Return text for a name or a table: one line, shortened in the middle."""
    line = " ".join(visible(text).split())
    if len(line) <= most:
        return line
    tail = most // 4
    return line[: most - tail - 1].rstrip() + "…" + line[-tail:].lstrip()


def cell(text: object) -> str:
    """Return text that a spreadsheet does not evaluate: formulas get an apostrophe in front.

    Tabs and line ends, which may begin one too, become spaces. Source: OWASP, "CSV Injection".
    """
    line = " ".join(_UNSEEN.sub("", readable(str(text))).split())
    return "'" + line if line.startswith(_FORMULA) and not _FIGURE.fullmatch(line) else line
