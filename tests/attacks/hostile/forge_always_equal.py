"""Publish a number that says it equals every other, in the hope that a check compares it.

gains: nothing
score: 20
outcome: completed, exception
"""

from kit import attempt, drive


class Right(float):
    """Equal to all, less than all, near to all."""

    def __eq__(self, other):
        return True

    def __ne__(self, other):
        return False

    def __lt__(self, other):
        return True

    def __gt__(self, other):
        return True

    def __le__(self, other):
        return True

    def __sub__(self, other):
        return Right(0.0)

    def __abs__(self):
        return Right(0.0)

    __hash__ = float.__hash__


def lie(node, scan):
    with attempt():
        node.drive(Right(0.2))


drive(lie)
