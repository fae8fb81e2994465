"""The verdicts that several checks of model_formats share."""

from __future__ import annotations

from grader.checks.ml_velocity.contract import Right
from grader.checks.model_formats.contract import model_file, right_speed
from grader.checks.moments import first_asked
from grader.checks.obstacle_avoidance.evidence import Answer, garbage, judged, spell
from grader.checks.verdict import fail
from grader.link.log import LogLine
from grader.recording import Recording

SPEED_TOLERANCE = 1e-3  # [m/s]; all formats compute in float32
LOUD = ("warn", "error", "fatal")
ABOUT_DEVICES = ("cuda", "gpu", "device")


def require_speeds(recording: Recording, tag: str = "", help: str = "") -> None:
    """Fail unless the node drove as the contract says after every scan with this tag."""
    for answer in judged(recording, tag):
        require_speed(recording, answer, help)


def require_speed(recording: Recording, answer: Answer, help: str = "") -> None:
    """Fail unless the command in force after this scan has the right linear.x."""
    right = right_speed(recording, answer.scan)
    what = f"{_what(recording, answer)}, with {model_file(recording.scenario)}"
    if answer.speed is None:
        fail(
            f"no command has come by {what}",
            expected=f"a Twist with linear.x = {right} m/s",
            actual="nothing on /cmd_vel",
            at=answer.scan.t,
            recording=recording,
            help="Publish once at the end of the scan callback, whatever the scan was.",
        )
    if not _is_right(answer.speed, right):
        fail(
            f"{what}: wrong speed",
            expected=f"linear.x = {right} m/s",
            actual=f"linear.x = {_precise(answer.speed)} m/s",
            at=answer.scan.t,
            recording=recording,
            help=garbage(answer.speed) or _said_in_the_log(recording) or help,
        )


def require_error_log(recording: Recording, why: str) -> None:
    """Fail unless the node logged an error."""
    if any(line.level in ("error", "fatal") for line in recording.log):
        return
    levels = ", ".join(sorted({line.level for line in recording.log}))
    fail(
        f"{why}, and the node does not say so",
        expected="an error in the log: self.get_logger().error(…)",
        actual=f"lines of level {levels} only" if levels else "an empty log",
        at=first_asked(recording),
        recording=recording,
        help="A robot that silently stands still costs an afternoon; say which file is the cause.",
    )


def loud_lines(recording: Recording) -> list[LogLine]:
    """Return the warnings and errors in the log."""
    return [line for line in recording.log if line.level in LOUD]


def remarks_on_devices(recording: Recording) -> list[LogLine]:
    """Return the warnings and errors that are about a device."""
    return [
        line
        for line in loud_lines(recording)
        if any(word in line.text.lower() for word in ABOUT_DEVICES)
    ]


def _said_in_the_log(recording: Recording) -> str:
    """Return the node's own first error: it mostly knows why it stands still."""
    errors = [line.text.strip() for line in recording.log if line.level in ("error", "fatal")]
    return f"The node's log says: {errors[0][:300]}" if errors else ""


def _what(recording: Recording, answer: Answer) -> str:
    if answer.label and not recording.scenario.faults.scan_loss:
        return f"“{answer.label}”"
    return f"the scan at {answer.scan.t:.3f} s"


def _is_right(speed: float, right: Right) -> bool:
    return right.low - SPEED_TOLERANCE <= speed <= right.high + SPEED_TOLERANCE


def _precise(speed: float) -> str:
    """Return a command with four digits, unless it is far from any speed."""
    return f"{speed:.4f}" if abs(speed) < 100 else spell(speed)
