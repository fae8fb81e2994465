"""Raise something whose text can't be formed, and that lies about its class and its cause.

gains: nothing
score: 0
outcome: exception
"""

from kit import drive


class Liar(BaseException):
    """Breaks whoever looks at it."""

    def __str__(self):
        raise RuntimeError("no text")

    __repr__ = __str__

    @property
    def __class__(self):
        return int


def inject(node, scan):
    error = Liar()
    error.__cause__ = error
    raise error


drive(inject)
