"""The verdicts that several checks of model_formats share."""

from __future__ import annotations

import math
import struct
from dataclasses import replace
from typing import NamedTuple

from grader.checks import model_commands
from grader.checks.commands import Answer, garbage, judged
from grader.checks.model_commands import scan_in_words
from grader.checks.predictions import SpeedInterval, max_speed
from grader.exercises.model_formats.contract import ORDER, is_predicted, model_file, right_speed
from grader.link.log import LogLine
from grader.recording import Recording

SPEED_TOLERANCE = 1e-3  # [m/s]; all formats compute in float32
ERRORS = ("error", "fatal")
LOUD = ("warn", *ERRORS)


class Habits(NamedTuple):
    """How a node commands what its model says (see `grader.exercises.model_formats.habits`)."""

    tolerance: float = SPEED_TOLERANCE  # [m/s]
    order: tuple[int, ...] = ORDER  # in which the model gets the features
    narrow: bool = False  # an np.float32 stands in linear.x


RIGHT = Habits()


def require_speeds(
    recording: Recording, tag: str = "", help: str = "", habits: Habits = RIGHT
) -> None:
    """Fail unless the node commanded the right speed after every scan of this tag."""
    tolerance = habits.tolerance
    found = []
    for raw in judged(recording, tag):
        right = right_speed(recording, raw.scan, habits.order)
        answer = replace(raw, speed=as_meant(raw.speed, right, habits))
        found.append(answer)
        what = scan_in_words(recording, answer)
        model_commands.require_speed(
            recording,
            answer,
            right,
            tolerance,
            what=f"{what}, with {model_file(recording.scenario)}",
            help=_advice(recording, answer, help),
        )
    if is_predicted(recording) and max_speed(recording.scenario) > 0.0:
        model_commands.require_said(recording, found, tolerance)


def as_meant(speed: float | None, right: SpeedInterval, habits: Habits) -> float | None:
    """Return a command [m/s], of an np.float32 what its author put in, if that is right.

    Its bits are the lower half of the double's; the upper half is memory that belongs to nobody.
    """
    if speed is None or not habits.narrow or right.allows(speed, habits.tolerance):
        return speed
    (meant,) = struct.unpack("<f", struct.pack("<d", speed)[:4])
    return float(meant) if right.allows(meant, habits.tolerance) else speed


def loud_lines(recording: Recording) -> list[LogLine]:
    """Return the warnings and errors in the log."""
    return [line for line in recording.log if line.level in LOUD]


def _advice(recording: Recording, answer: Answer, help: str) -> str:
    """Return what to look at after a wrong speed: the node's own error, if it logged one.

    It has to be about this scan, or from the start-up: what it says of other scans misleads.
    """
    scans = recording.scans()
    begin, first = answer.scan.t, scans[0].t if scans else math.inf
    end = next((scan.t for scan in scans if scan.t > begin), math.inf)
    errors = [line for line in recording.log if line.level in ERRORS]
    own = [line for line in errors if begin <= line.t < end or line.t < first]
    logged = f"The node's log says: {own[-1].text.strip()[:300]}" if own else ""
    return garbage(answer.speed or 0.0) or logged or help
