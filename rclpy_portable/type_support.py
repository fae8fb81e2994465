"""What generated message classes ask for before they are used: functions of a C library.

The runtime reads the classes themselves (cdr.py), so anything that is there will do.
"""

from __future__ import annotations


class UnsupportedTypeSupport(Exception):
    """A package has no type support; here every package has it."""


class _Library:
    """A package's library: it has every function."""

    def __getattr__(self, name: str) -> str:
        if name.startswith("__"):
            raise AttributeError(name)
        return name


def import_type_support(_package: str) -> _Library:
    """Return the type support of a package's messages."""
    return _Library()
