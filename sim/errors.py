"""The one error that `sim` shows to a person."""

from collections.abc import Sequence


class InputError(Exception):
    """An input is wrong: one line that says where, what came, and what was expected.

    Its text is written for the person who wrote the file, and is shown without a traceback.
    """

    def __init__(self, line: str, choices: Sequence[str] = ()) -> None:
        """Take the line, and names to choose from, each of which gets a line of its own."""
        lines = (line, *(f"  {choice}" for choice in choices))
        # keys and file names may hold line breaks
        super().__init__("\n".join(" ".join(each.splitlines()) for each in lines))
