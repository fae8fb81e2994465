"""How a check ends if it doesn't pass: it fails, or the machine allows no verdict; and evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

from grader.recording import Recording

Trials = Mapping[str, Recording]  # by the scenario's name


@dataclass(eq=False)
class CheckFailed(AssertionError):
    """The student's mistake."""

    message: str  # what happened, in a sentence
    expected: str = ""  # what the contract asks for, with units
    actual: str = ""  # what came
    at: float | None = None  # [s] in scenario time; the replay jumps there
    scenario: str | None = None  # the trial in which it happened
    help: str = ""  # what to look at next
    where: str = ""  # the student's lines that were being run, innermost first
    title: str = ""  # in place of the check's own: the node started, and died of one message

    def __str__(self) -> str:
        """Return what happened."""
        return self.message


class Inconclusive(Exception):
    """The machine's fault: there is no verdict."""


@dataclass(frozen=True)
class Evidence:
    """What recordings show of a mistake; the checks show its effects only.

    `seen(trials, failed)` of an exercise's `causes.py` returns it, or None. It says what was seen
    and when, with every seed.
    """

    text: str  # a sentence; what may lie behind it is asked
    hint: str = ""  # where it stands in hints.md: task and number, "2.1"
    explains: Sequence[str] = ()  # ids of failed checks whose own help would lead elsewhere


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
    """Fail the check: raise CheckFailed with these fields."""
    when, name = None if at is None else float(at), recording.name if recording else None
    raise CheckFailed(message, expected, actual, when, name, help, where, title)


def inconclusive(message: str) -> NoReturn:
    """Raise Inconclusive: the machine did not allow a verdict."""
    raise Inconclusive(message)
