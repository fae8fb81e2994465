"""Errors that a notebook shows as a sentence instead of our traceback."""

import textwrap
from collections.abc import Iterator
from contextlib import contextmanager

from grader.errors import InputError

MOST = 400  # [characters] of a sentence; a list of all scenarios has thousands


def sentence(text: str) -> str:
    """Return a message, shortened to fit a cell's output."""
    return text if len(text) <= MOST else textwrap.shorten(text, MOST, placeholder=" …")


class Refused(InputError):
    """A function was called with arguments that make no sense."""

    def _render_traceback_(self) -> list[str]:
        """Return the lines that IPython shows in place of a traceback."""
        return [str(self)]


@contextmanager
def kind_errors() -> Iterator[None]:
    """Turn wrong usage, and files that can't be read or written, into a sentence.

    Raises Refused: the block raised `InputError` or `OSError`.
    """
    try:
        yield
    except InputError as error:
        raise Refused(sentence(str(error))) from None
    except OSError as error:
        raise Refused(f"{error.filename or 'file'}: {error.strerror}") from None
