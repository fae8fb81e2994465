"""How a check ends if it doesn't pass: it fails, or the machine allows no verdict.

fail(
    "drove at 0.50 m/s with a wall 0.42 m ahead",
    expected="0.00 m/s", actual="0.50 m/s", at=scan.t, recording=recording,
    help="Compare the distance with 0.5 m before you publish.",
)

Tested with the plug-in that reads it (tests/grader/grading/test_plugin.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

from grader.recording import Recording


@dataclass(eq=False)
class CheckFailed(AssertionError):
    """The student's mistake."""

    message: str
    expected: str = ""
    actual: str = ""
    at: float | None = None  # [s]
    scenario: str | None = None
    help: str = ""
    where: str = ""
    title: str = ""  # in place of the check's own

    def __str__(self) -> str:
        """Return what happened."""
        return self.message

    @property
    def of_one_message(self) -> bool:
        """The node ran, and died of a message: where it lived on, other checks can judge it."""
        return bool(self.title)


class Inconclusive(Exception):
    """The machine's fault: there is no verdict."""


def fail(
    message: str,
    *,
    expected: str = "",
    actual: str = "",
    at: float | None = None,
    recording: Recording | None = None,
    help: str = "",
    where: str = "",
    title: str = "",
) -> NoReturn:
    """Fail the check.

    Parameters
    ----------
    message
        What happened, in a sentence for the student.
    expected, actual
        What the contract asks for, and what came, with units.
    at
        When, in scenario time [s]; the replay jumps there.
    recording
        The trial in which it happened.
    help
        What to look at next.
    where
        The student's lines that were being run, innermost first.
    title
        What is shown as the check's title: a node that dies of a message has started, and the
        checks that need this one are judged in the trials in which it lived on.

    Raises
    ------
    CheckFailed
        Always.
    """
    when, name = None if at is None else float(at), recording.name if recording else None
    raise CheckFailed(message, expected, actual, when, name, help, where, title)


def inconclusive(message: str) -> NoReturn:
    """Say that the machine did not allow a verdict.

    Raises
    ------
    Inconclusive
        Always.
    """
    raise Inconclusive(message)
