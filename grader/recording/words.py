"""What a node said around a moment: its log, what it printed, its diagnostics.

It is the program's own word, quoted to help its author; no verdict depends on it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from grader.recording.recording import Recording
from rclpy_virtual_time import LogLine
from sim.messages import decode

BEFORE, AFTER = 1.0, 0.05  # [s] around the moment
MAX_LINES = 3
MAX_TEXT = 300  # [characters] of one
# the stacks of a node that hangs, for which the judge asked; and what a library grumbles
NOISE = re.compile(
    r'  File ".*", line \d+ in |(Current t|T)hread 0x|  (Garbage-c|\.\.\.|<no Py)|\s*$'
    r"|.*\[[EW]:onnxruntime:"
    r"|\w+: pip has no package of it"
)
URGENT = ("warn", "error", "fatal", "stderr")
DIAGNOSTICS, DIAGNOSTIC_ARRAY = "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"


def words_of(recording: Recording, moment: float | None) -> list[str]:
    """Return the node's log around a moment [s]; of a whole run, its last warnings."""
    said = [line for line in recording.log if not NOISE.match(line.text)]
    if moment is None:
        return [_told(line) for line in said if line.level in URGENT][-MAX_LINES:]
    near = [line for line in said if moment - BEFORE <= line.t <= moment + AFTER]
    urgent = [line for line in near if line.level in URGENT]
    told = [_told(line) for line in (_different(urgent) or near)[-MAX_LINES:]]
    return told + _diagnostics(recording, moment)


def told_lines(lines: Iterable[LogLine]) -> list[str]:
    """Return lines that the node printed and logged, with their times."""
    return [_told(line) for line in lines if not NOISE.match(line.text)]


def _told(line: LogLine) -> str:
    level = "" if line.level in ("stdout", "stderr") else f"{line.level}: "
    return f"{line.t:.2f} s  {level}{line.text[:MAX_TEXT]}"


def _different(lines: list[LogLine]) -> list[LogLine]:
    """Leave out lines that are said again later."""
    last = {line.text: i for i, line in enumerate(lines)}
    return [line for i, line in enumerate(lines) if last[line.text] == i]


def _diagnostics(recording: Recording, moment: float) -> list[str]:
    """Return the newest diagnostic at that moment."""
    sent = [
        message
        for message in recording.published
        if message.topic == DIAGNOSTICS
        and message.type == DIAGNOSTIC_ARRAY
        and message.time / 1e9 <= moment + AFTER
    ]
    if not sent:
        return []
    try:
        array = decode(sent[-1].data, DIAGNOSTIC_ARRAY)
        texts = [f"{status.name}: {status.message}" for status in array.status[:1]]
    except Exception:  # the node's bytes may be anything
        return []
    return [f"{sent[-1].time / 1e9:.2f} s  {DIAGNOSTICS} {text[:MAX_TEXT]}" for text in texts]
