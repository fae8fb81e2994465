"""What can be done with structs."""

from dataclasses import fields, replace
from typing import Any

__all__ = ["astuple", "fields", "replace"]


def astuple(struct: Any) -> tuple[Any, ...]:
    """Return the values of the fields."""
    return tuple(getattr(struct, field.name) for field in fields(struct))
