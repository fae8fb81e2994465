"""The verdicts that several checks of model_formats share."""

from __future__ import annotations

from grader.checks import model_commands
from grader.checks.commands import Answer, garbage, judged
from grader.checks.model_commands import scan_in_words
from grader.checks.model_formats.contract import is_predicted, model_file, right_speed
from grader.link.log import LogLine
from grader.recording import Recording

SPEED_TOLERANCE = 1e-3  # [m/s]; all formats compute in float32
LOUD = ("warn", "error", "fatal")


def require_speeds(recording: Recording, tag: str = "", help: str = "") -> None:
    """Fail unless the node commanded the right speed after every scan with this tag."""
    found = judged(recording, tag)
    for answer in found:
        what = scan_in_words(recording, answer)
        model_commands.require_speed(
            recording,
            answer,
            right_speed(recording, answer.scan),
            SPEED_TOLERANCE,
            what=f"{what}, with {model_file(recording.scenario)}",
            help=_advice(recording, answer, help),
        )
    if is_predicted(recording):
        model_commands.require_said(recording, found, SPEED_TOLERANCE)


def loud_lines(recording: Recording) -> list[LogLine]:
    """Return the warnings and errors in the log."""
    return [line for line in recording.log if line.level in LOUD]


def _advice(recording: Recording, answer: Answer, help: str) -> str:
    """Return what to look at after a wrong speed: the node's own first error, if it logged one."""
    errors = [line.text.strip() for line in recording.log if line.level in ("error", "fatal")]
    logged = f"The node's log says: {errors[0][:300]}" if errors else ""
    return garbage(answer.speed or 0.0) or logged or help
