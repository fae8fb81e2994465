"""How a node died or hung, as its host told it: the place, the student's own lines, their values.

`grader.advice.deaths` writes what is read here. All of it is the program's own word: it explains a
failure, and never decides one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

MAX_LINES = 40
VALUES = "   ["  # before the values in the line of a frame
MAX_LINE = 420  # [characters]
FRAME = re.compile(r"(?P<file>[^/\n]{1,100}), line (?P<line>\d{1,6}), in (?P<function>\S{1,80})")


@dataclass(frozen=True)
class Frame:
    """A line of the student's in a traceback."""

    file: str
    line: int
    function: str
    source: str = ""
    values: str = ""  # "distance = None, speed = 0.5"

    def __str__(self) -> str:
        text = f"line {self.line} of {self.file}, in {self.function}"
        text += f":  {self.source}" if self.source else ""
        return text + (f"{VALUES}{self.values}]" if self.values else "")


@dataclass(frozen=True)
class Death:
    """A node's death by an exception; innermost frame first."""

    place: str  # "the callback of /scan", "a timer (0.1 s)", "the constructor", "the start-up"
    frames: tuple[Frame, ...]
    said: str = ""  # Python's own words
    advice: str = ""
    loop: str = ""  # "line 46, `while index < len(scan.ranges):`", of a node that hangs

    @property
    def in_callback(self) -> bool:
        """Whether the node died in a callback."""
        return self.place not in ("the constructor", "the start-up", "the script", "")

    @property
    def topic(self) -> str:
        """The topic in whose callback the node died; "" if in another callback."""
        before, _, topic = self.place.partition("the callback of ")
        return "" if before else topic


def death_of(detail: str) -> Death | None:
    """Return the death that an outcome's detail describes; None if there is none."""
    lines = [line[:MAX_LINE] for line in detail.partition("\n\n")[0].splitlines()[:MAX_LINES]]
    if not lines or not lines[0].startswith("in "):
        return None
    frames: list[Frame] = []
    said = advice = loop = ""
    for line in lines[1:]:
        if line.startswith("    "):
            if frames:
                frames[-1] = _with(frames[-1], line.strip())
        elif match := FRAME.fullmatch(line):
            frames.append(Frame(match["file"], int(match["line"]), match["function"]))
        elif line.startswith("try: "):
            advice = line.removeprefix("try: ")
        elif line.startswith("loop: "):
            loop = line.removeprefix("loop: ")
        else:
            said = line
    return Death(lines[0].removeprefix("in "), tuple(frames), said, advice, loop)


def told_first(detail: str) -> list[str]:
    """Return the lines to show where there is little room: the account, not the traceback."""
    if death_of(detail) is None:
        return []
    return [line[:MAX_LINE] for line in detail.partition("\n\n")[0].splitlines()[:MAX_LINES]]


def _with(frame: Frame, text: str) -> Frame:
    """Return the frame with its next line: first the source, then the values."""
    if frame.source:
        return Frame(frame.file, frame.line, frame.function, frame.source, text)
    return Frame(frame.file, frame.line, frame.function, text)
