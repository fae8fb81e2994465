"""The course's advice, as a host asks for it.

A host calls `Advisor` in the program's process.
"""

from __future__ import annotations

from pathlib import Path

from grader.advice import deaths, hints, slips
from grader.advice.message_words import field_that_is_wrong
from rclpy_virtual_time import Advice


class Advisor(Advice):
    """The course's advice."""

    def begin(self) -> None:
        """Let `os.system` say that it can't do anything."""
        hints.tell_of_shell_commands()

    def slips(self, source: bytes) -> list[str]:
        """Return sentences on the program's slips."""
        return slips.slips(source)

    def unused_imports(self, source: bytes) -> list[str]:
        """Return the names that a source imports and never uses."""
        return slips.unused_imports(source)

    def wrong_field(self, message: object) -> str:
        """Say which field of a message holds another type than it should."""
        return field_that_is_wrong(message)

    def cause(self, error: BaseException) -> BaseException:
        """Return the first exception, where a `finally:` has raised another."""
        return deaths.first_of(error)

    def hint(self, error: BaseException) -> str:
        """Return advice on an exception that comes from a node's surroundings."""
        return hints.hint(error)

    def account(self, error: BaseException, folder: Path) -> str:
        """Return the place, the program's own lines, the values there, and advice."""
        if isinstance(error, SyntaxError) and Path(error.filename or "").is_relative_to(folder):
            return deaths.account_of_syntax(error)
        return deaths.account(error, folder)
